"use strict";
/* Puts the page together. */
(() => {
  const {data, summary, state, names, labels, make, command, number, size, moment, slider} = Parts;
  const at = (id) => document.getElementById(id);
  const words = {good: "Good", check: "Check", rejected: "Rejected"};
  const leads = {
    good: "Nothing speaks against using this atlas.",
    check: "Usable, but look at what is named here before it is handed on.",
    rejected: data.is_study ? "Do not use this atlas. Correct what is named here and build again."
      : "Do not use this atlas. What is named here can be corrected in the study that it was made from.",
  };

  function sign(level) {
    const svg = make("svg", {viewBox: "0 0 24 24", "aria-hidden": "true"});
    const line = {stroke: "#fff", "stroke-width": 2.6, fill: "none", "stroke-linecap": "round", "stroke-linejoin": "round"};
    const ground = {good: "#14693f", check: "#b06f00", rejected: "#a61b14"}[level];
    svg.append(make("circle", {cx: 12, cy: 12, r: 11, fill: ground}),
               make("path", {...line, d: {good: "M6.8 12.4l3.6 3.6 7-7.6", check: "M12 6.2v7.2M12 17.4v.1", rejected: "M8 8l8 8M16 8l-8 8"}[level]}));
    return svg;
  }

  /* Name, key in report.json, unit, digits. */
  const shown = [["LV ejection fraction", "lv_ef_percent", "%"], ["LV EDV", "lv_edv_ml", "ml"], ["LV ESV", "lv_esv_ml", "ml"],
                 ["RV ejection fraction", "rv_ef_percent", "%"], ["RV EDV", "rv_edv_ml", "ml"], ["RV ESV", "rv_esv_ml", "ml"],
                 ["LV stroke volume", "lv_sv_ml", "ml"], ["RV stroke volume", "rv_sv_ml", "ml"], ["LV mass", "lv_mass_g", "g"],
                 ["Heart rate", "heart_rate_per_min", "/min"], ["Cardiac output", "cardiac_output_l_per_min", "l/min", 1]];

  function verdict() {
    const bad = data.findings.filter((finding) => finding.level !== "good");
    bad.sort((a, b) => (b.level === "rejected") - (a.level === "rejected"));
    const f = summary.figures;
    const between = (key) => {
      const interval = summary.intervals_90[key];
      return interval ? make("dd", {class: "interval", title: "90 % prediction interval"}, interval.map((end) => number(end)).join(" to ")) : null;
    };
    const some = shown.some(([, key]) => summary.intervals_90[key]);
    const header = at("verdict");
    header.classList.add(summary.verdict);
    header.append(make("div", {}, make("h1", {}, sign(summary.verdict), words[summary.verdict]), make("p", {class: "lead"}, leads[summary.verdict]),
                       data.is_study ? null : make("p", {class: "small"}, "Of the package alone: of leaks, boundaries that are hardly seen and slices moved back only its study's report tells."),
                       bad.length ? make("ul", {}, bad.map((finding) => make("li", {}, make("strong", {}, finding.trouble + ": "), finding.said,
                         finding.how ? make("p", {}, finding.how) : null, finding.commands.map(command)))) : null),
                  make("div", {}, make("dl", {class: "figures"}, shown.map(([name, key, unit, digits]) =>
                    make("div", {}, make("dt", {}, name), make("dd", {}, number(f[key], digits), make("small", {}, " " + unit)), between(key)))),
                    some ? make("p", {class: "small"}, "Below a figure: its 90 % prediction interval, from what the prior expects beside the labels. The true figures of 9 in 10 drawn hearts lie within theirs.") : null, known_surfaces()));
  }

  /* How near the true surfaces lie, a row each. */
  function known_surfaces() {
    const known = Object.entries(summary.surfaces_90);
    if (!known.length) return null;
    const mm = (value) => make("td", {}, number(value, 1));
    return make("div", {}, make("table", {}, make("caption", {}, "How near the true surface lies at end-diastole, with 90 % [mm]"),
        make("thead", {}, make("tr", {}, ...["", "In slices", "Worst slice", "At the base", "At the apex"].map((text) => make("th", {scope: "col"}, text)))),
        make("tbody", {}, known.map(([name, entry]) => make("tr", {}, make("th", {scope: "row"}, names[name]), mm(entry.in_slices_mm),
          make("td", {}, `${number(entry.worst_slice_mm, 1)} (slice ${entry.worst_slice})`), mm(entry.at_base_mm), mm(entry.at_apex_mm))))),
      make("p", {class: "small"}, "In slices: along an outline's normal, the median of the slices. At the base and the apex: where the surface lies flat in the last slice. Of drawn hearts 90 % of each surface lie within. The package tells it of every place."));
  }

  function compared() {
    const before = summary.before;
    if (!before) return;
    at("compared").hidden = false;
    const rows = [["Verdict", words[before.verdict], words[summary.verdict]],
                  ["To look at", before.places.length, summary.places.length]];
    const leaks = (report) => report.places.filter((place) => place.kind === "leak");
    rows.push(["Leak alarms", leaks(before).length, leaks(summary).length]);
    /* Those of one kind and structure together: an area, or how far a volume jumps. */
    const sizes = (report) => {
      const out = new Map();
      for (const place of leaks(report)) {
        const key = `${place.alarm}, ${names[place.structure]}`;
        out.set(key, (out.get(key) || 0) + place.figure);
      }
      return out;
    };
    const was = sizes(before), is = sizes(summary);
    for (const key of new Set([...was.keys(), ...is.keys()])) {
      const unit = /^(volume-jump|open-cycle)/.test(key) ? "% of the volume" : "mm²";
      const said = (value) => value === undefined ? "none" : `${number(value)} ${unit}`;
      rows.push(["Alarm: " + key, said(was.get(key)), said(is.get(key))]);
    }
    for (const [name, key, unit] of shown) rows.push([name, `${number(before.figures[key], 1)} ${unit}`, `${number(summary.figures[key], 1)} ${unit}`]);
    at("compared").append(make("h2", {}, "Before and after"),
      make("table", {}, make("thead", {}, make("tr", {}, ...["", "Build before", "This build"].map((text) => make("th", {scope: "col"}, text)))),
           make("tbody", {}, rows.map((row) => make("tr", {}, make("th", {scope: "row"}, row[0]), make("td", {}, String(row[1])), make("td", {}, String(row[2])))))));
  }

  function show_button(place, n) {
    return make("button", {type: "button", "aria-label": `Show place ${n + 1} on image and surface`, on: {click: () => {
      state.set({slice: place.slice, phase: place.phase, place: n});
      at("views").scrollIntoView();
    }}}, "Show");
  }

  function where(place) {
    return `slice ${place.slice}, ${moment(place.phase)}, (${place.lps_mm.map((v) => v.toFixed(0)).join(", ")}) mm LPS`;
  }

  /* Why there is no seed that could be run as it stands, and what to do. */
  function remark(first) {
    if (/ LABEL /.test(first)) return make("p", {}, `No seed is known that would mend this: the surface may be right and only not be seen. Where it is wrong, put for LABEL what the image shows there (${labels.join(", ")}):`);
    if (/^beatlas seeds/.test(first)) return null;
    return make("p", {}, "No seed is offered: labels were painted or given here and stay as they are. Where they are wrong, paint segment/labels.nii.gz with the editor that drew them, and build again:");
  }

  function correct() {
    if (!data.places.length) return;
    const section = at("correct");
    section.hidden = false;
    const count = (n) => make("span", {class: "count"}, String(n + 1));
    const numbered = data.places.map((place, n) => [place, n]);
    const leaks = numbered.filter(([place]) => place.kind === "leak");
    const uncertain = numbered.filter(([place]) => place.kind !== "leak");
    section.append(make("h2", {id: "correct-title"}, leaks.length ? "Look here and correct" : "Worth a look"),
      make("p", {class: "small"}, "Numbers are those on images and surfaces. Run the commands in the study's folder, where build leaves report.html; only what changed is made anew, and the package that the study made last is written again where it lies, in the study or beside it (elsewhere, or where there are copies: name it with -o). A seed says what lies there; a click into the large image below gives the command for any other place. Labels can also be painted: segment/labels.nii.gz over exam/stack.nii.gz in an editor of label images, saved over the same file; build again."));
    if (leaks.length) {
      section.append(make("ol", {class: "places"}, leaks.map(([place, n]) => make("li", {class: "place leak"},
        make("h3", {}, count(n), make("span", {}, place.title), show_button(place, n)),
        make("p", {class: "small"}, where(place)), make("p", {}, place.sentence),
        remark(place.commands[0]),
        place.commands.map(command)))));
    }
    if (uncertain.length) {
      section.append(make("div", {class: "place uncertain"}, make("h3", {}, "Boundaries that are hardly seen"),
        make("ul", {class: "rows"}, uncertain.map(([place, n]) => make("li", {}, count(n),
          make("p", {}, make("strong", {}, place.title.replace(/^Uncertain: /, "").replace(/^./, (c) => c.toUpperCase())), make("br"), place.sentence.replace(/; compare.*/, "") + "; " + where(place)), show_button(place, n)))),
        make("p", {}, "Compare outline and image; where the outline is wrong, click into the image at what is taken for something else, run the command that is shown there, and build again:"), command(uncertain[0][0].commands.at(-1))));
    }
  }

  function beat() {
    if (!Object.keys(summary.volumes_ml).length) return;
    at("beat").hidden = false;
    const rows = Array.from({length: summary.phases}, (_, p) => make("tr", {}, make("td", {class: "number"}, String(p)), make("td", {class: "number"}, Parts.time(p).toFixed(0)),
      Object.values(summary.volumes_ml).map((curve) => make("td", {class: "number"}, curve[p].toFixed(1)))));
    at("curves").append(Charts.curves(), make("figcaption", {}, `Volumes of the ${data.is_study ? "segmentation" : "package's distances"} over one beat. ED and ES: end-diastole and end-systole.`),
      make("details", {}, make("summary", {}, "All volumes [ml]"), make("div", {class: "scroll"}, make("table", {},
        make("thead", {}, make("tr", {}, ["Phase", "ms", ...Object.keys(summary.volumes_ml).map((name) => names[name])].map((text) => make("th", {class: "number", scope: "col"}, text)))),
        make("tbody", {}, rows)))));
    at("ranges").append(...Charts.ranges());
  }

  function legend() {
    for (const name of data.slices.structures) {
      const line = make("span", {class: "line"});
      line.style.background = data.colours[name];
      at("legend").append(make("label", {}, make("input", {type: "checkbox", checked: true, on: {change: (event) => {
        state.set({shown: {...state.shown, [name]: event.target.checked}});
      }}}), line, names[name]));
    }
  }

  function phases() {
    const bar = slider("Phase of the beat", {min: 0, max: summary.phases - 1, step: 1, value: state.phase}, moment, (phase) => { stop(); state.set({phase}); });
    let running = 0;
    const button = make("button", {type: "button", "aria-pressed": "false", on: {click: () => (running ? stop() : play())}}, "▶ Beat");
    function stop() {
      if (!running) return;
      cancelAnimationFrame(running);
      running = 0;
      button.setAttribute("aria-pressed", "false");
      button.textContent = "▶ Beat";
    }
    function play() {
      const start = performance.now() - Parts.time(state.phase);
      button.setAttribute("aria-pressed", "true");
      button.textContent = "■ Stop";
      const tick = (now) => {
        const phase = Math.floor((now - start) / Parts.time(1)) % summary.phases;
        if (phase !== state.phase && phase >= 0) state.set({phase});
        running = requestAnimationFrame(tick);
      };
      running = requestAnimationFrame(tick);
    }
    const jump = (text, phase, title) => phase === null ? null :
      make("button", {type: "button", title, "aria-label": title, on: {click: () => { stop(); state.set({phase}); }}}, text);
    at("phase-bar").append(button, ...[jump("ED", summary.end_diastole, "End-diastole"), jump("ES", summary.end_systole, "End-systole")].filter(Boolean), bar.label, bar.input, bar.out);
    state.on((change) => { if ("phase" in change) bar.show(state.phase); });
  }

  /* A package may hold no images, or nothing of which a slice could be drawn. */
  function images() {
    const shown = data.slices.list.length > 0;
    for (const id of ["slice-view", "strip", "strip-title", "paper"]) at(id).hidden = !shown;
    at("strip").parentElement.hidden = !shown;
    if (shown) Slices.large(at("slice-view"));
    if (!data.is_study) {
      at("legend").before(make("p", {class: "small"},
        data.has_images ? "The images are those in the package: what lies around the heart and stands out of the noise. Outlines are where its distances are zero in the middle of a slice."
        : shown ? `This package, of the scene ${data.package.scene}, holds no images: outlines are where its distances are zero in the middle of a slice.`
        : `This package, of the scene ${data.package.scene}, holds nothing of which slices could be drawn.`));
    }
  }

  function mark(level) { return make("span", {class: "mark " + level}, {good: "✓ ", check: "! ", rejected: "✕ "}[level] + words[level].toLowerCase()); }

  function checks() {
    at("checks").append(make("table", {class: "stack"},
      make("thead", {}, make("tr", {}, ["", "Checked", "Found", "Limit", "Why"].map((text) => make("th", {scope: "col"}, text)))),
      make("tbody", {}, data.findings.map((finding) => make("tr", {}, make("td", {}, mark(finding.level)), make("th", {scope: "row"}, finding.title),
        make("td", {"data-title": "Found"}, finding.said), make("td", {"data-title": "Limit"}, finding.limit), make("td", {class: "small"}, finding.why))))));
  }

  /* What slices and phases say of each other, where the study was asked. */
  function foretold() {
    const test = summary.self_test;
    if (!test) return;
    at("foretold").hidden = false;
    const kinds = [["between_slices", `Slices between two others, foretold over ${test.slices_apart_mm.toFixed(1)} mm`], ["at_ends", "Slices beside an end"],
                   ["between_phases", `Phases, foretold over ${(1000 * test.phases_apart_s).toFixed(0)} ms`]].filter(([key]) => test[key].length);
    const rows = kinds.flatMap(([key, title]) => test[key].map((row, n) => make("tr", {}, make("td", {}, n ? "" : title), make("th", {scope: "row"}, names[row.structure]),
      make("td", {class: "number"}, row.mean_mm.toFixed(1)), make("td", {class: "number"}, row.p95_mm.toFixed(1)), make("td", {class: "number"}, Math.abs(row.bias_mm) < 0.05 ? "0.0" : (row.bias_mm > 0 ? "+" : "−") + Math.abs(row.bias_mm).toFixed(1)))));
    at("foretold").append(make("p", {}, "Every other slice was hidden, and foretold by the others as the atlas is made of them; phases likewise. How far that lies from their own outlines, in mm; outward is +, and 6 stands for 6 and more. The atlas lies closer than that between its slices, which are half as far apart."),
      make("div", {class: "scroll"}, make("table", {}, make("thead", {}, make("tr", {}, ["Hidden", "", "Mean mm", "95 % within", "Outward"].map((text, n) => make("th", {scope: "col", class: n > 1 ? "number" : ""}, text)))), make("tbody", {}, rows))),
      make("p", {class: "small"}, "Foretold worst, between two others: " + test.worst.map((place) => `${names[place.structure]} in slice ${place.slice}, phase ${place.phase} (${place.mean_mm.toFixed(1)} mm)`).join("; ") + "."));
  }

  function record() {
    if (summary.slice_shifts_mm.length) {
      at("shifts").hidden = false;
      at("shifts").append(make("figure", {}, Charts.shifts(), make("figcaption", {}, "How far each slice lay from its place in its plane, as the images tell; it was moved back before segmentation. Beyond 5 mm look whether outlines run on smoothly.")));
    }
    const size_text = data.source_size.join(" × ");
    at("import").append(make("dl", {class: "facts"}, make("dt", {}, "Images"), make("dd", {}, `${data.source_format}, ${size_text} voxels of ${data.slices.spacing_mm.map((v) => v.toFixed(2)).join(" × ")} mm, ${summary.phases} phases`),
      make("dt", {}, "Beat"), make("dd", {}, `R-R ${(1000 * summary.rr_interval_s).toFixed(0)} ms; source frames at ${data.frame_times_s.map((t) => (1000 * t).toFixed(0)).join(", ")} ms`),
      data.is_study ? [make("dt", {}, "Long-axis views"), make("dd", {}, String(data.views))] : null),
      make("ul", {class: "plain"}, data.decisions.map((text) => make("li", {}, text))));
    if (data.package) {
      at("package").hidden = false;
      at("package").append(make("p", {}, `Scene ${data.package.scene}, ${size(data.package.bytes)}.`),
        make("div", {class: "scroll"}, make("table", {class: "stack"}, make("thead", {}, make("tr", {}, make("th", {scope: "col"}, "Item"), make("th", {class: "number", scope: "col"}, "Bytes"), make("th", {scope: "col"}, "Error of storing it"), make("th", {scope: "col"}, "SHA-256"))),
          make("tbody", {}, data.package.items.map((item) => make("tr", {}, make("th", {scope: "row"}, item.what.replace(/^\w+/, (name) => names[name] || name)), make("td", {class: "number"}, item.bytes.toLocaleString("en")),
            make("td", {}, item.error), make("td", {class: "hash", title: item.sha256}, item.sha256.slice(0, 16) + "…")))))));
    }
    const facts = [[data.is_study ? "Made by" : "Report made by", summary.program], ["Images, SHA-256", summary.input_sha256], ["Package, SHA-256", data.package ? data.package.sha256 : "none"], ["Report made from", summary.made_from],
                   ...(data.is_study ? [["Seeds drawn", String(data.drawn_seeds)]] : []), ["File last written", document.lastModified.replace(/(\d+)\/(\d+)\/(\d+)/, "$3-$1-$2")]];
    at("provenance").append(make("dl", {class: "facts"}, facts.map(([name, text]) => [make("dt", {}, name), make("dd", {class: /SHA|from/.test(name) ? "hash" : ""}, text || "–")])),
      make("div", {class: "scroll"}, make("table", {}, make("thead", {}, make("tr", {}, ["Stage", "State", "Version", "Time", "Changed by hand"].map((text) => make("th", {scope: "col"}, text)))),
        make("tbody", {}, data.stages.map((stage) => make("tr", {}, make("th", {scope: "row"}, stage.name), make("td", {}, stage.state), make("td", {}, stage.version || "–"),
          make("td", {}, !data.is_study ? "–" : stage.wall_s === undefined ? "kept" : stage.wall_s.toFixed(1) + " s"), make("td", {}, stage.edited.join(", ") || "–")))))),
      make("details", {}, make("summary", {}, "Options of every stage"), make("pre", {tabindex: 0}, JSON.stringify(Object.fromEntries(data.stages.map((stage) => [stage.name, stage.options])), null, 1))));
  }

  verdict();
  compared();
  correct();
  beat();
  legend();
  phases();
  images();
  checks();
  foretold();
  record();
  window.addEventListener("beforeprint", () => { for (const each of document.querySelectorAll("details")) if (!each.closest("footer")) each.open = true; });
  window.beatlas = {state};
  /* The verdict is on the screen before surfaces and small pictures are made. */
  window.addEventListener("load", () => requestAnimationFrame(() => setTimeout(() => {
    Heart.build(at("heart-view"));
    if (data.slices.list.length) {
      Slices.strip(at("strip"));
      Slices.paper(at("paper"));
    }
    document.body.dataset.ready = Math.round(performance.now());
  })));
})();
