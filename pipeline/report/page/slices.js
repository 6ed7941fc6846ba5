"use strict";
/* The images with the outlines on them: one slice large, all of them small. */
const Slices = (() => {
  const {data, summary, state, labels, make, command, bytes, moment, slider} = Parts;
  const slices = data.slices;
  const [width, height] = slices.size || [1, 1];
  const spacing = slices.spacing_mm;
  const parts = 32;  // of a voxel, in the outlines
  const sheets = slices.list.map(() => null);
  const lines = slices.list.map(() => null);

  /* [phase][structure] -> paths in voxels of the part that is shown; pixel centres whole. */
  function outlines(k) {
    if (lines[k] || !slices.list[k].outlines) return lines[k];
    const raw = bytes(slices.list[k].outlines);
    const words = new DataView(raw.buffer);
    let at = 0;
    const next = () => { at += 2; return words.getInt16(at - 2, true); };
    lines[k] = [];
    for (let phase = 0; phase < summary.phases; ++phase) {
      lines[k].push(slices.structures.map(() => {
        const path = new Path2D();
        for (let n = next(); n > 0; --n) {
          for (let p = next() & 0xffff, first = true; p > 0; --p, first = false) {
            const x = next() / parts + 0.5, y = next() / parts + 0.5;
            if (first) path.moveTo(x, y); else path.lineTo(x, y);
          }
          path.closePath();
        }
        return path;
      }));
    }
    return lines[k];
  }

  function sheet(k) {
    if (!sheets[k]) {
      const image = new Image();
      image.src = slices.list[k].image;
      sheets[k] = image.decode().then(() => image);
    }
    return sheets[k];
  }

  /* How the part lies in a canvas of w x h: square millimetres, as large as fits. */
  function placed(w, h) {
    const fit = Math.min(w / (width * spacing[0]), h / (height * spacing[1]));
    const fx = fit * spacing[0], fy = fit * spacing[1];
    return {fit, fx, fy, x0: (w - width * fx) / 2, y0: (h - height * fy) / 2};
  }

  /* Fits the part into the canvas and draws; `thick` in CSS pixels. */
  async function draw(canvas, k, phase, thick, rings) {
    canvas.dataset.wanted = `${k} ${phase}`;
    const image = await sheet(k);
    if (canvas.dataset.wanted !== `${k} ${phase}`) return;
    const ratio = window.devicePixelRatio || 1;
    /* What is on paper alone has no size on the screen, and keeps its own. */
    const w = canvas.clientWidth ? Math.round(canvas.clientWidth * ratio) : canvas.width;
    const h = canvas.clientHeight ? Math.round(canvas.clientHeight * ratio) : canvas.height;
    if (canvas.width !== w || canvas.height !== h) { canvas.width = w; canvas.height = h; }
    const context = canvas.getContext("2d");
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.clearRect(0, 0, w, h);
    const {fit, fx, fy, x0, y0} = placed(w, h);
    const [tw, th] = slices.tile;
    const used = [Math.max(1, Math.round(width * slices.scale)), Math.max(1, Math.round(height * slices.scale))];
    context.imageSmoothingQuality = "high";
    context.drawImage(image, phase % slices.columns * tw, Math.floor(phase / slices.columns) * th, used[0], used[1],
                      x0, y0, width * fx, height * fy);
    const found = outlines(k);
    if (found) {
      context.lineJoin = "round";
      /* Blood last: where its outline is the muscle's too, its colour is seen. */
      for (const name of ["heart", "lv_myocardium", "ra_blood", "aorta", "la_blood", "rv_blood", "lv_blood"]) {
        const s = slices.structures.indexOf(name);
        if (s < 0 || !state.shown[name]) continue;
        const path = new Path2D();
        path.addPath(found[phase][s], new DOMMatrix([fx, 0, 0, fy, x0, y0]));
        context.strokeStyle = data.colours[name];
        context.lineWidth = thick * ratio;
        context.stroke(path);
      }
    }
    if (!rings) return;
    data.places.forEach((place, n) => {
      if (place.slice !== k) return;
      const x = x0 + (place.index[0] - slices.first[0] + 0.5) * fx;
      const y = y0 + (place.index[1] - slices.first[1] + 0.5) * fy;
      const now = place.phase === phase;
      context.strokeStyle = place.kind === "leak" ? "#ff5be3" : "#b9bdff";
      context.fillStyle = context.strokeStyle;
      context.lineWidth = (now ? 2.5 : 1.2) * ratio;
      context.setLineDash(now ? [] : [4 * ratio, 4 * ratio]);
      context.beginPath();
      context.arc(x, y, 9 * fit, 0, 2 * Math.PI);
      context.stroke();
      context.setLineDash([]);
      context.font = `600 ${13 * ratio}px system-ui, sans-serif`;
      context.fillText(String(n + 1), x + 9.5 * fit, y - 6 * fit);
    });
  }

  function large(panel) {
    const canvas = make("canvas", {role: "img", tabindex: 0, "aria-label": ""});
    const caption = make("div", {class: "caption"});
    const bar = slider("Slice", {min: 0, max: slices.list.length - 1, step: 1, value: state.slice},
                       (k) => `${k} (0 to ${slices.list.length - 1})`, (k) => state.set({slice: k}));
    canvas.addEventListener("keydown", (event) => {
      const step = {ArrowUp: [1, 0], ArrowDown: [-1, 0], ArrowRight: [0, 1], ArrowLeft: [0, -1]}[event.key];
      if (!step) return;
      event.preventDefault();
      state.set({slice: Math.min(slices.list.length - 1, Math.max(0, state.slice + step[0])),
                 phase: (state.phase + step[1] + summary.phases) % summary.phases});
    });
    panel.append(make("div", {class: "stage"}, canvas, caption),
                 make("div", {class: "controls"}, make("div", {class: "field"}, bar.label, bar.input, bar.out)),
                 ...seeding(canvas));
    const show = () => {
      const shift = slices.list[state.slice].shift_mm;
      const moved = shift && Math.hypot(shift[0], shift[1]) >= 0.05 ? `, moved back ${Math.hypot(shift[0], shift[1]).toFixed(1)} mm` : "";
      caption.textContent = `slice ${state.slice}, ${moment(state.phase)}${moved}`;
      canvas.setAttribute("aria-label", `Image and outlines of ${caption.textContent}. Arrow keys: up and down another slice, left and right another phase.`);
      bar.show(state.slice);
      draw(canvas, state.slice, state.phase, 1.6, true);
    };
    show();
    state.on(show);
    window.addEventListener("resize", show);
  }

  /* A click says which voxel it met and gives the command that marks it, but where labels were drawn:
     no seed changes those. */
  function seeding(canvas) {
    const drawn = new Set(data.drawn_phases);
    if (!data.is_study || drawn.size === summary.phases) return [];
    const choice = make("select", {id: "seed-label"}, labels.map((name) => make("option", {value: name}, name)));
    const holder = make("div", {"aria-live": "polite"});
    const box = make("div", {class: "seed", hidden: true}, make("div", {class: "field"}, make("label", {for: "seed-label"}, "What lies there"), choice), holder);
    let met = null;
    const tell = () => {
      if (!met) return;
      box.hidden = false;
      choice.disabled = drawn.has(met.phase);
      holder.replaceChildren(choice.disabled ? make("p", {class: "small"}, `The labels of phase ${met.phase} were given and stay as they are, whatever is marked there: correct them where they were drawn, or mark another phase.`)
        : command(`beatlas seeds . add --label ${choice.value} --slice ${met.slice} --row ${met.row} --column ${met.column} --phase ${met.phase}`));
    };
    choice.addEventListener("change", tell);
    canvas.addEventListener("click", (event) => {
      const shown = canvas.getBoundingClientRect();
      const {fx, fy, x0, y0} = placed(shown.width, shown.height);
      const x = Math.floor((event.clientX - shown.left - x0) / fx), y = Math.floor((event.clientY - shown.top - y0) / fy);
      if (x < 0 || y < 0 || x >= width || y >= height) return;
      met = {slice: state.slice, phase: state.phase, column: slices.first[0] + x, row: slices.first[1] + y};
      tell();
    });
    return [box];
  }

  function strip(holder) {
    const seen = new Set();
    const small = slices.list.map((_, k) => {
      const canvas = make("canvas", {"aria-hidden": "true"});
      canvas.style.aspectRatio = `${width * spacing[0]} / ${height * spacing[1]}`;
      const count = data.places.filter((place) => place.slice === k).length;
      const button = make("button", {type: "button", "aria-pressed": k === state.slice, "aria-label": `Slice ${k}` + (count ? `, ${count} to look at` : ""),
                                     on: {click: () => state.set({slice: k})}},
                          canvas, make("span", {}, String(k)), count ? make("span", {class: "flag"}, "!") : null);
      holder.append(button);
      return {button, canvas};
    });
    const redraw = (k) => draw(small[k].canvas, k, state.phase, 1, false);
    const watch = new IntersectionObserver((entries) => {
      for (const entry of entries) {
        const k = small.findIndex((each) => each.button === entry.target);
        if (entry.isIntersecting) { seen.add(k); redraw(k); } else { seen.delete(k); }
      }
    }, {rootMargin: "200px"});
    small.forEach((each) => watch.observe(each.button));
    state.on((change) => {
      small.forEach((each, k) => each.button.setAttribute("aria-pressed", String(k === state.slice)));
      if ("phase" in change || "shown" in change) seen.forEach(redraw);
    });
    /* What was never on the screen is drawn too, so that it is there on paper. */
    const rest = (k) => {
      if (k >= small.length) { document.body.dataset.strip = "drawn"; return; }
      const after = () => (window.requestIdleCallback || setTimeout)(() => rest(k + 1));
      if (seen.has(k)) after(); else redraw(k).then(after);
    };
    setTimeout(() => rest(0), 300);
  }

  /* For paper, where no slider moves: every slice at end-diastole and end-systole. */
  async function paper(holder) {
    const moments = [["End-diastole", summary.end_diastole], ["End-systole", summary.end_systole]];
    for (const [name, phase] of moments) {
      if (phase === null) continue;
      const strip = make("div", {class: "strip"});
      holder.append(make("h3", {}, `${name}, phase ${phase}`), strip);
      for (let k = 0; k < slices.list.length; ++k) {
        const canvas = make("canvas", {role: "img", "aria-label": `Slice ${k} at ${name.toLowerCase()} with outlines`});
        canvas.style.aspectRatio = `${width * spacing[0]} / ${height * spacing[1]}`;
        canvas.width = 208;
        canvas.height = Math.round(208 * height * spacing[1] / (width * spacing[0]));
        strip.append(make("div", {class: "tile"}, canvas, make("span", {}, String(k))));
        await draw(canvas, k, phase, 1, false);
      }
    }
    document.body.dataset.paper = "drawn";
  }

  return {large, strip, paper};
})();
