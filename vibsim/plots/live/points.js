"use strict";
// The page of a table of points: two panels over one column, coloured by another; a point tells its numbers.

const columns = {};
for (const column of DATA.columns) {
  const values = decoded(column.data, Float64Array);
  columns[column.name] = { ...column, values, places: column.log ? values.map(Math.log10) : values }; // where it is drawn
}
const main = document.querySelector("main"), left = element("div", undefined, main), side = element("div", undefined, main);
const nav = document.querySelector("nav");
const nameOf = (column) => column.title || column.name;
const label = (column) => nameOf(column) + (column.unit ? " (" + column.unit + ")" : "");
let chosen = -1;

function picker(text, start, names) {
  const holder = element("label", text + " ", nav), select = element("select", undefined, holder);
  for (const name of names) element("option", name ? columns[name].title || name : "none", select).value = name;
  select.value = start;
  select.addEventListener("change", () => reset());
  return select;
}
const single = Object.values(columns).filter((column) => column.width === 1).map((column) => column.name);
const x = picker("x", DATA.x, single);
const y = [picker("above", DATA.y[0], Object.keys(columns)), picker("below", DATA.y[1], Object.keys(columns))];
const by = picker("colour", DATA.colour, ["", ...single]);
const panels = [0, 1].map((i) => new Axes(left, 270, i ? " " : "", "", i ? "lower panel" : "upper panel"));
if (curve) signs(left, meaning);

function bounds(values) {
  let low = Infinity, high = -Infinity;
  for (const value of values) { if (value < low) low = value; if (value > high) high = value; }
  return [low, high];
}

// viridis of matplotlib: its lightness rises evenly, so that equal steps look equal, in grey too
const VIRIDIS = ["440154", "482878", "3e4989", "31688e", "26828e", "1f9e89", "35b779", "6ece58", "b5de2b", "fde725"].map((hex) => [0, 2, 4].map((k) => parseInt(hex.slice(k, k + 2), 16)));
function shade(share) {
  const along = Math.min(Math.max(share, 0), 1) * (VIRIDIS.length - 1), i = Math.min(Math.floor(along), VIRIDIS.length - 2), s = along - i;
  return `rgb(${VIRIDIS[i].map((part, k) => Math.round(part + s * (VIRIDIS[i + 1][k] - part))).join(",")})`;
}

// the values by which points are coloured: each its own colour while they are few, else a scale
function shades() {
  if (!by.value) return () => colour("c0");
  const column = columns[by.value], different = [...new Set(column.values)].sort((a, b) => a - b);
  if (different.length <= 7) return (row) => colour("c" + Math.max(different.indexOf(column.values[row]), 0));
  const [low, high] = bounds(column.values);
  return (row) => { const s = (column.values[row] - low) / (high - low || 1); return Number.isFinite(s) ? shade(s) : colour("dim"); };
}

function legend() {
  if (!by.value) return [];
  const column = columns[by.value], different = [...new Set(column.values)].filter(Number.isFinite).sort((a, b) => a - b);
  if (different.length <= 7) return different.map((value, i) => [nameOf(column) + " = " + wordOf(column, value), colour("c" + i)]);
  const [low, high] = bounds(different);
  return [[nameOf(column) + " from " + wordOf(column, low), shade(0)], ["to " + wordOf(column, high), shade(1)]];
}

const wordOf = (column, value) => column.words && column.words[value] !== undefined ? column.words[value] : shortNumber(value);

function redraw() {
  const xs = columns[x.value], shadeOf = shades();
  panels.forEach((axes, k) => {
    const ys = columns[y[k].value], width = ys.width;
    axes.legend = k === 0 ? legend() : [];
    axes.x = view.range; axes.yLabel = label(ys); axes.xLabel = k ? label(xs) : "";
    axes.xLog = Boolean(xs.log); axes.yLog = Boolean(ys.log);
    axes.words = ys.words && Object.entries(ys.words).map(([code, word]) => [Number(code), word]);
    let low = Infinity, high = -Infinity;
    for (let row = 0; row < DATA.count; row++) {
      if (xs.places[row] < view.range[0] || xs.places[row] > view.range[1]) continue;
      for (let m = 0; m < width; m++) { const value = ys.places[row * width + m]; if (value < low) low = value; if (value > high && value < Infinity) high = value; }
    }
    const [least, greatest] = reachOf(x.value, y[k].value, view.range);
    axes.fit(Math.min(low, least), Math.max(high, greatest));
  });
  align(panels);
  panels.forEach((axes, k) => {
    const ys = columns[y[k].value], width = ys.width;
    const g = axes.begin(), size = curve || width > 1 ? 1.2 : DATA.count > 2000 ? 1.6 : 2.6;
    drawCurve(axes, x.value, y[k].value);
    for (let row = 0; row < DATA.count; row++) {
      const px = axes.px(xs.places[row]);
      if (px < axes.left - 4 || px > axes.width) continue;
      g.fillStyle = shadeOf(row);
      for (let m = 0; m < width; m++) {
        const value = ys.places[row * width + m];
        if (value === value) { g.beginPath(); g.arc(px, axes.py(value), size, 0, 7); g.fill(); }
      }
    }
    drawMarks(axes, x.value, y[k].value);
    const at = chosen < DATA.count ? [xs.places, ys.places, width] : pairOf(marks.columns, x.value, y[k].value);
    const row = chosen < DATA.count ? chosen : chosen - DATA.count;
    if (chosen >= 0 && at) {
      g.strokeStyle = colour("mark"); g.lineWidth = 2;
      for (let m = 0; m < width; m++) { g.beginPath(); g.arc(axes.px(at[0][row]), axes.py(at[1][row * width + m]), 8, 0, 7); g.stroke(); }
    }
    axes.end();
  });
  main.dataset.from = view.range[0]; main.dataset.to = view.range[1]; main.dataset.chosen = chosen;
}

// a point by its row; a special point by its row behind those
function choose(row) {
  chosen = row;
  const rows = [];
  if (row >= DATA.count) return chooseMark(row - DATA.count);
  for (const column of Object.values(columns)) {
    if (column.width > 1) continue;
    const value = column.values[row];
    if (value === value) rows.push([column.title || column.name, wordOf(column, value) + (column.unit ? " " + column.unit : "")]);
  }
  for (const [name, texts] of Object.entries(DATA.texts)) if (texts[row]) rows.push([name, texts[row]]);
  tell(rows, DATA.commands ? DATA.commands[row] : "");
  redraw();
}

function chooseMark(row) {
  const rows = Object.entries(marks.texts).filter(([, texts]) => texts[row]).map(([name, texts]) => [name, texts[row]]);
  for (const [name, column] of Object.entries(marks.columns)) {
    const value = column.values[row], unit = columns[name].unit ? " " + columns[name].unit : "";
    if (column.width === 1 && Number.isFinite(value)) rows.push([columns[name].title || name, (name === "parameter" ? Number(value.toPrecision(12)) : shortNumber(value)) + unit]);
  }
  tell(rows, "");
  redraw();
}

function hover(axes, k) {
  return (px, py) => {
    const xs = columns[x.value], ys = columns[y[k].value], width = ys.width;
    let best = -1, least = 900;
    for (let row = 0; row < DATA.count; row++) for (let m = 0; m < width; m++) {
      const dx = axes.px(xs.places[row]) - px, dy = axes.py(ys.places[row * width + m]) - py, distance = dx * dx + dy * dy;
      if (distance < least) { least = distance; best = row; }
    }
    const pair = marks && pairOf(marks.columns, x.value, y[k].value);
    for (let row = 0; pair && row < marks.count; row++) for (let m = 0; m < pair[2]; m++) {
      const dx = axes.px(pair[0][row]) - px, dy = axes.py(pair[1][row * pair[2] + m]) - py, distance = dx * dx + dy * dy;
      if (distance <= Math.max(least, 36)) { least = distance; best = DATA.count + row; }
    }
    if (best >= 0 && best !== chosen) choose(best);
  };
}

function fullRange() {
  const every = [columns, curve && curve.columns, marks && marks.columns].filter((one) => one && one[x.value]);
  const places = (column) => [...(column.places || column.values)];
  const [low, high] = bounds(every.flatMap((one) => places(one[x.value])).filter(Number.isFinite));
  const margin = (high - low) * 0.03 || Math.abs(high) * 0.1 || 1;
  return low <= high ? [low - margin, high + margin] : [0, 1];
}

function reset() { const full = fullRange(); view.full = full; view.least = (full[1] - full[0]) * 1e-6; view.all(); }

// the next point in the order of the table
function step(way) { choose(chosen < 0 || chosen >= DATA.count ? 0 : Math.min(Math.max(chosen + way, 0), DATA.count - 1)); }

const view = new View([0, 1], 1e-6, redraw);
buttons([["everything", "all points (0)", () => view.all()], ["+", "closer (+)", () => view.zoom(0.5)], ["−", "further (-)", () => view.zoom(2)]]);
const toggle = theme(redraw);
keys({
  ArrowLeft: () => view.pan(-0.2 * (view.range[1] - view.range[0])), ArrowRight: () => view.pan(0.2 * (view.range[1] - view.range[0])),
  "+": () => view.zoom(0.5), "-": () => view.zoom(2), "0": () => view.all(), Home: () => view.all(),
  n: () => step(1), p: () => step(-1), d: () => toggle(),
});
panels.forEach((axes, k) => listen(axes, view, hover(axes, k)));
side.append(document.getElementById("readout"));
new ResizeObserver(redraw).observe(main);
reset();
