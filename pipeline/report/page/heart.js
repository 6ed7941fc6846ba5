"use strict";
/* The beating surfaces, to turn and to cut. */
const Heart = (() => {
  const {data, summary, state, make, bytes, moment, slider, names} = Parts;
  const order = {heart: 1, lv_myocardium: 2, rv_blood: 3, ra_blood: 4, aorta: 5, la_blood: 6, lv_blood: 7};

  function decoded(surface) {
    const places = new Uint16Array(bytes(surface.positions).buffer);
    const count = surface.vertices * 3;
    const phases = [];
    for (let p = 0; p < summary.phases; ++p) {
      const out = new Float32Array(count);
      for (let i = 0; i < count; ++i) out[i] = surface.origin_mm[i % 3] + surface.step_mm * places[p * count + i];
      phases.push(out);
    }
    const geometry = new THREE.BufferGeometry();
    geometry.setIndex(new THREE.BufferAttribute(new Uint16Array(bytes(surface.triangles).buffer), 1));
    geometry.setAttribute("position", new THREE.BufferAttribute(phases[0].slice(), 3));
    return {name: surface.structure, phases, geometry, normals: phases.map(() => null)};
  }

  const vector = (list) => new THREE.Vector3(list[0], list[1], list[2]);

  function number(n, leak) {
    const canvas = make("canvas", {width: 64, height: 64});
    const context = canvas.getContext("2d");
    context.fillStyle = leak ? "#b0149b" : "#5b5f97";
    context.beginPath();
    context.arc(32, 32, 28, 0, 2 * Math.PI);
    context.fill();
    context.fillStyle = context.strokeStyle = "#fff";
    context.lineWidth = 4;
    context.stroke();
    context.font = "600 34px system-ui, sans-serif";
    context.textAlign = "center";
    context.textBaseline = "middle";
    context.fillText(String(n), 32, 34);
    const map = new THREE.CanvasTexture(canvas);
    const sprite = new THREE.Sprite(new THREE.SpriteMaterial({map, depthTest: false, sizeAttenuation: false}));
    sprite.scale.setScalar(0.035);
    sprite.renderOrder = 50;
    return sprite;
  }

  function build(panel) {
    const canvas = make("canvas", {role: "img", tabindex: 0});
    const caption = make("div", {class: "caption"});
    const stage = make("div", {class: "stage"}, canvas, caption);
    panel.append(stage);
    if (!data.surfaces.length || !data.axes) {
      stage.replaceChildren(make("p", {class: "caption"}, "This study holds no surfaces yet."));
      return;
    }
    const drawing = canvas.getContext("webgl", {antialias: true, stencil: true, preserveDrawingBuffer: true, alpha: false});
    if (!drawing) {
      stage.replaceChildren(make("p", {class: "caption"}, "This browser draws no 3-D (WebGL is off)."));
      return;
    }
    const renderer = new THREE.WebGLRenderer({canvas, context: drawing, antialias: true, preserveDrawingBuffer: true});
    renderer.setClearColor(0x14181e);
    renderer.localClippingEnabled = true;
    const scene = new THREE.Scene();
    const camera = new THREE.PerspectiveCamera(28, 1, 10, 2000);
    scene.add(camera, new THREE.HemisphereLight(0xffffff, 0x9aa3ad, 0.62));
    const lamp = new THREE.DirectionalLight(0xffffff, 0.55);
    lamp.position.set(-0.4, 0.7, 1);
    camera.add(lamp);

    const surfaces = data.surfaces.map(decoded);
    const box = new THREE.Box3();
    const point = new THREE.Vector3();
    for (const surface of surfaces) {
      for (let i = 0; i < surface.phases[0].length; i += 3) box.expandByPoint(point.fromArray(surface.phases[0], i));
    }
    const centre = box.getCenter(new THREE.Vector3());
    const extent = box.getSize(new THREE.Vector3()).length() / 2;
    const axes = {};
    for (const [name, list] of Object.entries(data.axes)) axes[name] = vector(list).normalize();
    const base = axes.towards_base || axes.superior;

    const plane = new THREE.Plane(new THREE.Vector3(0, 0, -1), 0);
    let cutting = false;
    const caps = new THREE.Group();
    const bodies = surfaces.map((surface) => {
      const tint = data.colours[surface.name];
      const skin = new THREE.Mesh(surface.geometry, new THREE.MeshPhongMaterial({color: tint, specular: 0x222222, shininess: 18, side: THREE.DoubleSide,
        /* Where two surfaces lie on each other the outer one is seen. */
        polygonOffset: surface.name !== "heart", polygonOffsetFactor: 6 - order[surface.name], polygonOffsetUnits: 8}));
      skin.renderOrder = order[surface.name] + 10;
      const counting = [[THREE.BackSide, THREE.IncrementWrapStencilOp], [THREE.FrontSide, THREE.DecrementWrapStencilOp]].map(([side, op]) => {
        const mesh = new THREE.Mesh(surface.geometry, new THREE.MeshBasicMaterial({
          side, colorWrite: false, depthWrite: false, depthTest: false, stencilWrite: true, stencilFunc: THREE.AlwaysStencilFunc,
          stencilFail: op, stencilZFail: op, stencilZPass: op, clippingPlanes: [plane]}));
        mesh.renderOrder = order[surface.name];
        return mesh;
      });
      const cap = new THREE.Mesh(new THREE.PlaneBufferGeometry(6 * extent, 6 * extent), new THREE.MeshBasicMaterial({
        color: new THREE.Color(tint).lerp(new THREE.Color(0xffffff), 0.22), side: THREE.DoubleSide, stencilWrite: true, stencilRef: 0,
        stencilFunc: THREE.NotEqualStencilFunc, stencilFail: THREE.ReplaceStencilOp, stencilZFail: THREE.ReplaceStencilOp, stencilZPass: THREE.ReplaceStencilOp}));
      cap.renderOrder = order[surface.name] + 0.5;
      cap.onAfterRender = () => renderer.clearStencil();
      scene.add(skin, ...counting, cap);
      return {surface, skin, counting, cap};
    });
    const spots = data.places.map((place, n) => {
      if (!place.workspace_mm) return null;
      const spot = number(n + 1, place.kind === "leak");
      spot.position.copy(vector(place.workspace_mm));
      scene.add(spot);
      return spot;
    });

    const controls = new THREE.OrbitControls(camera, canvas);
    controls.enableKeys = false;
    controls.enablePan = false;
    controls.target.copy(centre);
    controls.minDistance = extent;
    controls.maxDistance = 12 * extent;
    camera.up.copy(axes.superior);

    function look(direction) {
      camera.position.copy(centre).addScaledVector(direction.clone().normalize(), 3.1 * extent);
      controls.update();
      render();
    }

    const cut = {way: "none", place: 0};
    function place_cut() {
      cutting = cut.way !== "none";
      if (cutting) {
        const towards = cut.way === "short" ? base.clone()
          : cut.way === "long" ? axes.posterior.clone().negate().addScaledVector(base, axes.posterior.dot(base)).normalize()
          : camera.position.clone().sub(centre).normalize();
        plane.setFromNormalAndCoplanarPoint(towards.clone().negate(), centre.clone().addScaledVector(towards, cut.place / 100 * extent));
      }
      for (const body of bodies) {
        body.skin.material.clippingPlanes = cutting ? [plane] : [];
        plane.coplanarPoint(body.cap.position);
        body.cap.lookAt(body.cap.position.clone().sub(plane.normal));
      }
    }

    function render() {
      place_cut();
      for (const {surface, skin, counting, cap} of bodies) {
        const shown = state.shown[surface.name];
        skin.visible = shown;
        /* Uncut, the heart is a veil over what lies in it. */
        const veil = surface.name === "heart" && !cutting;
        skin.material.transparent = veil;
        skin.material.opacity = veil ? 0.22 : 1;
        skin.material.depthWrite = !veil;
        skin.material.side = veil ? THREE.FrontSide : THREE.DoubleSide;
        counting.forEach((mesh) => { mesh.visible = shown && cutting; });
        cap.visible = shown && cutting;
      }
      const w = stage.clientWidth, h = stage.clientHeight;
      renderer.setPixelRatio(window.devicePixelRatio || 1);
      if (canvas.width !== Math.floor(w * renderer.getPixelRatio()) || canvas.height !== Math.floor(h * renderer.getPixelRatio())) renderer.setSize(w, h, false);
      camera.aspect = w / h;
      camera.updateProjectionMatrix();
      renderer.render(scene, camera);
    }

    function show_phase() {
      for (const surface of surfaces) {
        const position = surface.geometry.attributes.position;
        position.array.set(surface.phases[state.phase]);
        position.needsUpdate = true;
        if (!surface.normals[state.phase]) {
          surface.geometry.computeVertexNormals();
          surface.normals[state.phase] = surface.geometry.attributes.normal.array.slice();
        } else {
          surface.geometry.attributes.normal.array.set(surface.normals[state.phase]);
          surface.geometry.attributes.normal.needsUpdate = true;
        }
        surface.geometry.computeBoundingSphere();
      }
      data.places.forEach((place, n) => { if (spots[n]) spots[n].material.opacity = place.phase === state.phase || state.place === n ? 1 : 0.55; });
      caption.textContent = moment(state.phase);
      canvas.setAttribute("aria-label", `Surfaces of ${surfaces.map((s) => names[s.name]).join(", ")}, ${moment(state.phase)}. Arrow keys turn them, plus and minus change their size.`);
      render();
    }

    function turn(about, angle) {
      const arm = camera.position.clone().sub(controls.target).applyAxisAngle(about, angle);
      camera.position.copy(controls.target).add(arm);
      controls.update();
      render();
    }
    function grow(factor) {
      camera.position.sub(controls.target).multiplyScalar(factor).add(controls.target);
      controls.update();
      render();
    }
    canvas.addEventListener("keydown", (event) => {
      const right = new THREE.Vector3().crossVectors(camera.up, camera.position.clone().sub(controls.target)).normalize();
      const act = {ArrowLeft: () => turn(camera.up, 0.17), ArrowRight: () => turn(camera.up, -0.17), ArrowUp: () => turn(right, 0.17),
                   ArrowDown: () => turn(right, -0.17), "+": () => grow(0.9), "-": () => grow(1.1)}[event.key];
      if (!act) return;
      event.preventDefault();
      act();
    });
    /* The wheel scrolls the page unless the picture was chosen. */
    controls.enableZoom = false;
    canvas.addEventListener("focus", () => { controls.enableZoom = true; });
    canvas.addEventListener("blur", () => { controls.enableZoom = false; });
    controls.addEventListener("change", render);

    const views = {Front: axes.posterior.clone().negate().addScaledVector(axes.left, 0.45).addScaledVector(axes.superior, 0.15),
                   Left: axes.left.clone(), Back: axes.posterior.clone(), Base: base.clone().addScaledVector(axes.superior, 0.02), Apex: base.clone().negate().addScaledVector(axes.superior, 0.02)};
    const ways = make("select", {id: "cut-way", on: {change: () => { cut.way = ways.value; bar.input.disabled = cut.way === "none"; render(); }}},
                      ...[["none", "whole"], ["short", "across the long axis"], ["long", "along the long axis"], ["view", "towards you"]].map(([value, text]) => make("option", {value}, text)));
    const bar = slider("Cut at", {min: -100, max: 100, step: 1, value: 0, disabled: true}, (v) => `${(v / 100 * extent).toFixed(0)} mm`, (v) => { cut.place = v; render(); });
    panel.append(make("div", {class: "controls"}, ...Object.entries(views).map(([name, direction]) => make("button", {type: "button", on: {click: () => look(direction)}}, name)),
                      make("button", {type: "button", "aria-label": "Larger", on: {click: () => grow(0.85)}}, "+"),
                      make("button", {type: "button", "aria-label": "Smaller", on: {click: () => grow(1.18)}}, "−")),
                 make("div", {class: "controls"}, make("label", {for: "cut-way"}, "Cut"), ways, make("div", {class: "field"}, bar.label, bar.input, bar.out)));
    look(views.Front);
    show_phase();
    state.on((change) => { if ("phase" in change || "place" in change) show_phase(); else if ("shown" in change) render(); });
    window.addEventListener("resize", render);
  }

  return {build};
})();
