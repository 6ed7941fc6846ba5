"use strict";
/* Drawings of figures: volumes over the beat, normal ranges, shifts of slices. */
const Charts = (() => {
  const {data, summary, state, names, inks, make, number, time} = Parts;

  function ticks(most, wanted) {
    const rough = most / wanted;
    const power = Math.pow(10, Math.floor(Math.log10(rough)));
    const step = [1, 2, 2.5, 5, 10].map((f) => f * power).find((s) => s >= rough);
    const out = [];
    for (let at = 0; at <= most + 1e-9; at += step) out.push(at);
    return out;
  }

  function curves() {
    const chambers = ["lv_blood", "rv_blood", "lv_myocardium"].filter((name) => summary.volumes_ml[name]);
    const shown = chambers.length > 0 ? chambers : ["heart"];  // where no chamber was recognised
    const box = {width: 580, height: 350, left: 46, right: 88, top: 26, bottom: 40};
    const all = shown.flatMap((name) => summary.volumes_ml[name]);
    const marks = ticks(Math.max(...all) * 1.05, 5);
    const top = Math.max(marks[marks.length - 1], Math.max(...all) * 1.03);
    const period = 1000 * summary.rr_interval_s;
    const x = (ms) => box.left + (box.width - box.left - box.right) * ms / period;
    const y = (ml) => box.height - box.bottom - (box.height - box.top - box.bottom) * ml / top;
    const svg = make("svg", {class: "chart", viewBox: `0 0 ${box.width} ${box.height}`, role: "img",
                             "aria-label": "Volumes over the beat: " + shown.map((name) =>
                               `${names[name]} from ${number(Math.min(...summary.volumes_ml[name]))} to ${number(Math.max(...summary.volumes_ml[name]))} ml`).join(", ")});
    for (const ml of marks) {
      svg.append(make("line", {x1: box.left, x2: box.width - box.right, y1: y(ml), y2: y(ml), stroke: "#dfe4e9"}),
                 make("text", {x: box.left - 8, y: y(ml) + 4, "text-anchor": "end"}, String(ml)));
    }
    for (const ms of ticks(period, 5)) {
      svg.append(make("text", {x: x(ms), y: box.height - box.bottom + 18, "text-anchor": "middle"}, ms.toFixed(0)));
    }
    svg.append(make("text", {x: box.left - 8, y: 13, "text-anchor": "end"}, "ml"),
               make("text", {x: x(period), y: box.height - 6, "text-anchor": "end"}, "ms after the R wave"));
    for (const [phase, name] of [[summary.end_diastole, "ED"], [summary.end_systole, "ES"]]) {
      svg.append(make("line", {x1: x(time(phase)), x2: x(time(phase)), y1: box.top, y2: box.height - box.bottom, stroke: "#8d98a4", "stroke-dasharray": "3 4"}),
                 make("text", {class: "strong", x: x(time(phase)), y: 16, "text-anchor": phase === 0 ? "start" : "middle"}, name));
    }
    const cursor = make("line", {y1: box.top, y2: box.height - box.bottom, stroke: "#155a94", "stroke-width": 1.5});
    svg.append(cursor);
    const ends = [];
    for (const name of shown) {
      const volumes = summary.volumes_ml[name];
      const points = volumes.concat(volumes[0]).map((ml, p) => `${x(time(p)).toFixed(1)} ${y(ml).toFixed(1)}`);
      svg.append(make("path", {d: "M" + points.join("L"), fill: "none", stroke: inks[name], "stroke-width": 2.4, "stroke-linejoin": "round"}));
      volumes.forEach((ml, p) => svg.append(make("circle", {cx: x(time(p)), cy: y(ml), r: 2.6, fill: inks[name]})));
      ends.push({name, y: y(volumes[0]) + 4});
    }
    ends.sort((a, b) => a.y - b.y);
    ends.forEach((end, i) => {
      if (i > 0) end.y = Math.max(end.y, ends[i - 1].y + 15);
      const text = make("text", {x: box.width - box.right + 8, y: end.y}, names[end.name]);
      text.style.fill = inks[end.name];
      text.style.fontWeight = 600;
      svg.append(text);
    });
    const follow = () => {
      cursor.setAttribute("x1", x(time(state.phase)));
      cursor.setAttribute("x2", x(time(state.phase)));
    };
    follow();
    state.on((change) => { if ("phase" in change) follow(); });
    return svg;
  }

  /* Where a value lies beside the ranges of men and women. */
  function range(entry, value) {
    const most = Math.max(entry.men[1], entry.women[1], value) * 1.12;
    const x = (v) => 200 * v / most;
    const svg = make("svg", {class: "chart", viewBox: "0 0 200 34", role: "img",
                             "aria-label": `${number(value)} ${entry.unit}; men ${entry.men.join(" to ")}, women ${entry.women.join(" to ")}`});
    svg.append(make("line", {x1: 0, x2: 200, y1: 17, y2: 17, stroke: "#dfe4e9"}),
               make("rect", {x: x(entry.men[0]), width: x(entry.men[1]) - x(entry.men[0]), y: 7, height: 8, rx: 2, fill: "#9fc0dd"}),
               make("rect", {x: x(entry.women[0]), width: x(entry.women[1]) - x(entry.women[0]), y: 19, height: 8, rx: 2, fill: "#c9b6e0"}),
               make("polygon", {points: `${x(value)},4 ${x(value) + 5},17 ${x(value)},30 ${x(value) - 5},17`, fill: "#18222d"}));
    return svg;
  }

  function ranges() {
    const figures = summary.figures;
    const rows = [];
    const used = new Set();
    const before = summary.before;
    for (const entry of data.normal.ranges) {
      const value = figures[entry.figure];
      if (value === null || value === undefined) continue;
      used.add(entry.source);
      rows.push(make("tr", {}, make("th", {scope: "row"}, entry.title),
                     make("td", {class: "number"}, `${number(value)} ${entry.unit}`,
                          before ? make("div", {class: "small"}, `before ${number(before.figures[entry.figure])}`) : null),
                     entry.other ? make("td", {class: "small"}, entry.other) : make("td", {class: "range"}, range(entry, value)),
                     ...[["Men", entry.men], ["Women", entry.women]].map(([who, limits]) => make("td", {class: "number", "data-title": who}, limits ? limits.join("–") : "–")),
                     make("td", {"data-title": "From"}, String.fromCharCode(97 + entry.source))));
    }
    const head = make("thead", {}, make("tr", {}, make("th", {scope: "col"}, "Figure"), make("th", {class: "number", scope: "col"}, "Here"),
                                        make("th", {scope: "col"}, "◆ here; normal in men (blue), women (violet)"), make("th", {class: "number", scope: "col"}, "Men"),
                                        make("th", {class: "number", scope: "col"}, "Women"), make("th", {scope: "col"}, "From")));
    const sources = data.normal.sources.map((source, i) => !used.has(i) ? null :
      make("li", {}, `${String.fromCharCode(97 + i)}  ${source.citation} (${source.how})`));
    return [make("div", {class: "scroll"}, make("table", {class: "stack"}, head, make("tbody", {}, rows))),
            make("p", {class: "small"}, `Normal is where 95 of 100 healthy adults lie; size, age and training move it, and a patient's heart may well lie outside without any fault of the atlas. Mass is muscle at end-diastole times 1.05 g/ml; papillary muscles count as ${data.normal.papillary}.`),
            make("details", {}, make("summary", {}, "Sources: " + data.normal.sources.map((source, i) => used.has(i) ? `${String.fromCharCode(97 + i)} ${source.name}` : null).filter(Boolean).join(", ")), make("ul", {class: "plain small"}, sources))];
  }

  function shifts() {
    const list = summary.slice_shifts_mm.map((s) => Math.hypot(s[0], s[1]));
    const most = Math.max(5.5, ...list);
    const step = 560 / list.length;
    const y = (mm) => 120 - 100 * mm / most;
    const svg = make("svg", {class: "chart", viewBox: "0 0 620 150", role: "img",
                             "aria-label": `Shift of each slice, at most ${Math.max(...list).toFixed(1)} mm`});
    for (const mm of ticks(most, 3)) {
      svg.append(make("line", {x1: 40, x2: 600, y1: y(mm), y2: y(mm), stroke: "#dfe4e9"}),
                 make("text", {x: 32, y: y(mm) + 4, "text-anchor": "end"}, String(mm)));
    }
    list.forEach((mm, k) => {
      svg.append(make("rect", {x: 40 + step * k + step * 0.15, width: step * 0.7, y: y(mm), height: 120 - y(mm), fill: mm > 5 ? "#c98000" : "#5d7f9e"},
                      make("title", {}, `slice ${k}: ${mm.toFixed(1)} mm`)));
      if (k % Math.ceil(list.length / 16) === 0) svg.append(make("text", {x: 40 + step * (k + 0.5), y: 136, "text-anchor": "middle"}, String(k)));
    });
    svg.append(make("text", {x: 32, y: 12, "text-anchor": "end"}, "mm"), make("text", {x: 600, y: 148, "text-anchor": "end"}, "slice"));
    return svg;
  }

  return {curves, ranges, shifts};
})();
