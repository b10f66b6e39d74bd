"use strict";
// The curve that points lie on, where there is one: of a branch, solid where orbits are stable, dashed where not,
// with marks; of a locus.

function decodedColumns(packed) {
  const columns = {};
  for (const [name, column] of Object.entries(packed)) columns[name] = { width: column.width, values: decoded(column.data, Float64Array) };
  return columns;
}
const curve = DATA.lines ? { pieces: DATA.lines.pieces, words: DATA.lines.words, columns: decodedColumns(DATA.lines.columns) } : null;
const marks = DATA.marks ? { ...DATA.marks, columns: decodedColumns(DATA.marks.columns), count: DATA.marks.texts.kind.length } : null;

// paths of the marks about a place, filled or not, as pictures have them; other kinds have a dot
const SHAPES = {
  fold: [false, (g) => { g.moveTo(-4, -4); g.lineTo(4, 4); g.moveTo(-4, 4); g.lineTo(4, -4); }],
  doubling: [false, (g) => g.rect(-4, -4, 8, 8)],
  "neimark-sacker": [false, (g) => { g.moveTo(0, -5.5); g.lineTo(5.5, 0); g.lineTo(0, 5.5); g.lineTo(-5.5, 0); g.closePath(); }],
  "branch point": [true, (g) => { g.rect(-1.7, -5, 3.4, 10); g.rect(-5, -1.7, 10, 3.4); }],
  corner: [true, (g) => { g.moveTo(-5, -4); g.lineTo(5, -4); g.lineTo(0, 5); g.closePath(); }],
  hopf: [true, (g) => { for (let i = 0; i < 10; i++) g.lineTo((i % 2 ? 2.4 : 6) * Math.sin(i * Math.PI / 5), -(i % 2 ? 2.4 : 6) * Math.cos(i * Math.PI / 5)); g.closePath(); }],
  grazing: [false, (g) => { g.moveTo(-5, 4); g.lineTo(5, 4); g.lineTo(0, -5); g.closePath(); }],
  sticking: [false, (g) => { for (const turn of [0.5, 1.1667, 1.8333]) { g.moveTo(0, 0); g.lineTo(5.5 * Math.cos(turn * Math.PI), 5.5 * Math.sin(turn * Math.PI)); } }],
};

function drawMark(g, kind, x, y) {
  const [filled, path] = SHAPES[kind] || [true, (g) => g.arc(0, 0, 2.2, 0, 7)];
  g.save(); g.translate(x, y); g.setLineDash([]);
  g.beginPath(); path(g);
  g.strokeStyle = colour("ink"); g.lineWidth = 1.4;
  g.fillStyle = filled ? colour("ink") : colour("paper");
  if (filled || (kind !== "fold" && kind !== "sticking")) g.fill();
  g.stroke(); g.restore();
}

// both columns along the curve, or at its special points; null where one is not known there
function pairOf(columns, x, y) { return columns[x] && columns[y] ? [columns[x].values, columns[y].values, columns[y].width] : null; }

function drawCurve(axes, x, y) {
  const pair = curve && pairOf(curve.columns, x, y);
  if (!pair) return;
  const [xs, ys, width] = pair, g = axes.g;
  g.strokeStyle = colour("c0"); g.lineWidth = 1.4; g.lineJoin = "round";
  for (const [begin, end, stable] of curve.pieces) {
    g.setLineDash(stable ? [] : [5, 4]);
    for (let m = 0; m < width; m++) {
      g.beginPath();
      for (let row = begin; row < end; row++) g.lineTo(axes.px(xs[row]), axes.py(ys[row * width + m]));
      g.stroke();
    }
  }
  g.setLineDash([]);
}

function drawMarks(axes, x, y) {
  const pair = marks && pairOf(marks.columns, x, y);
  if (!pair) return;
  const [xs, ys, width] = pair;
  for (let row = 0; row < marks.count; row++) for (let m = 0; m < width; m++) {
    const value = ys[row * width + m];
    if (Number.isFinite(value)) drawMark(axes.g, marks.texts.kind[row], axes.px(xs[row]), axes.py(value));
  }
}

// least and greatest of a column along the curve where x is in a range
function reachOf(x, y, [from, to]) {
  let low = Infinity, high = -Infinity;
  for (const one of [curve, marks]) {
    const pair = one && pairOf(one.columns, x, y);
    if (!pair) continue;
    const [xs, ys, width] = pair;
    for (let row = 0; row < xs.length; row++) {
      if (xs[row] < from || xs[row] > to) continue;
      for (let m = 0; m < width; m++) {
        const value = ys[row * width + m];
        if (Number.isFinite(value)) { low = Math.min(low, value); high = Math.max(high, value); }
      }
    }
  }
  return [low, high];
}

// what lines and marks mean: [text, colour, how its sign is drawn]
function meaning() {
  if (!curve) return [];
  const line = (dash) => (g, x, y) => { g.strokeStyle = colour("c0"); g.lineWidth = 1.4; g.setLineDash(dash); g.beginPath(); g.moveTo(x - 8, y); g.lineTo(x + 6, y); g.stroke(); g.setLineDash([]); };
  const told = [];
  for (const code of [1, 0]) {
    if (curve.pieces.some((piece) => piece[2] === code)) told.push([curve.words[code], colour("ink"), line(code ? [] : [5, 4])]);
  }
  if (!marks) return told;
  for (const kind of Object.keys(SHAPES)) {
    if (marks.texts.kind.includes(kind)) told.push([marks.names[kind], colour("ink"), (g, x, y) => drawMark(g, kind, x, y)]);
  }
  if (marks.texts.kind.some((kind) => !SHAPES[kind])) told.push(["another change", colour("ink"), (g, x, y) => drawMark(g, "", x, y)]);
  return told;
}
