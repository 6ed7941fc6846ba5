"use strict";
/* What all parts of the page share: the data, the moment and slice shown, and small helpers. */
const Parts = (() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const summary = data.summary;

  const listeners = [];
  const state = {
    phase: summary.end_diastole || 0,
    slice: Math.floor(data.slices.list.length / 2),
    shown: {heart: true, lv_blood: true, rv_blood: true, lv_myocardium: true, la_blood: true, ra_blood: true,
            aorta: true},
    place: -1,
    set(change) {
      Object.assign(this, change);
      for (const listener of listeners) listener(change);
    },
    on(listener) { listeners.push(listener); },
  };

  const names = {heart: "Heart", lv_blood: "LV blood", rv_blood: "RV blood", lv_myocardium: "LV muscle",
                 la_blood: "LA blood", ra_blood: "RA blood", aorta: "Aorta"};
  /* For lines and words on a light ground. */
  const inks = data.inks;

  /* What a seed can say that lies at its place. */
  const labels = ["background", "rv_blood", "lv_myocardium", "lv_blood", "rest_of_heart"];

  function make(tag, properties, ...children) {
    const svg = ["svg", "path", "line", "rect", "circle", "text", "g", "title", "polygon"].includes(tag);
    const out = svg ? document.createElementNS("http://www.w3.org/2000/svg", tag) : document.createElement(tag);
    for (const [key, value] of Object.entries(properties || {})) {
      if (key === "on") {
        for (const [event, call] of Object.entries(value)) out.addEventListener(event, call);
      } else if (value === true) {
        out.setAttribute(key, "");
      } else if (value !== false && value !== null && value !== undefined) {
        out.setAttribute(key, value);
      }
    }
    for (const child of children.flat(Infinity)) {
      if (child !== null && child !== undefined) out.append(child);
    }
    return out;
  }

  function bytes(text) {
    const raw = atob(text);
    const out = new Uint8Array(raw.length);
    for (let i = 0; i < raw.length; ++i) out[i] = raw.charCodeAt(i);
    return out;
  }

  function command(text) {
    const button = make("button", {type: "button", on: {click: () => {
      const done = () => { button.textContent = "Copied"; setTimeout(() => { button.textContent = "Copy"; }, 1500); };
      if (navigator.clipboard) { navigator.clipboard.writeText(text).then(done, () => {}); }
    }}}, "Copy");
    return make("div", {class: "command"}, make("code", {}, text), button);
  }

  const number = (value, digits) =>
    value === null || value === undefined ? "–" : value.toFixed(digits === undefined ? 0 : digits);

  function size(count) {
    return count < 1e4 ? count + " bytes" : count < 1e6 ? (count / 1e3).toFixed(0) + " kB" : (count / 1e6).toFixed(2) + " MB";
  }

  const time = (phase) => 1000 * summary.rr_interval_s * phase / summary.phases;
  function moment(phase) {
    const name = phase === summary.end_diastole ? ", end-diastole" : phase === summary.end_systole ? ", end-systole" : "";
    return `phase ${phase}, ${time(phase).toFixed(0)} ms${name}`;
  }

  /* A slider with its label and what it says. */
  function slider(label, properties, say, change) {
    const id = "slider-" + label.toLowerCase().replace(/[^a-z]+/g, "-");
    const out = make("output", {for: id});
    const input = make("input", {type: "range", id, ...properties});
    const tell = () => {
      out.textContent = say(Number(input.value));
      input.setAttribute("aria-valuetext", out.textContent);
    };
    input.addEventListener("input", () => { tell(); change(Number(input.value)); });
    tell();
    return {input, label: make("label", {for: id}, label), out,
            show(value) { if (Number(input.value) !== value) input.value = value; tell(); }};
  }

  return {data, summary, state, names, labels, inks, make, command, bytes, number, size, time, moment, slider};
})();
