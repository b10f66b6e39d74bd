"use strict";
// The page of a run: panels over one time axis, the phase portrait of what is seen of it.

const t = decoded(DATA.t, Float64Array);
const columns = {};
for (const [name, { data, type }] of Object.entries(DATA.columns)) columns[name] = decoded(data, type === "f8" ? Float64Array : Float32Array);
const events = { t: decoded(DATA.events.t, Float64Array), kind: decoded(DATA.events.kind, Int8Array), part: decoded(DATA.events.part, Int16Array) };
const impacts = events.t.filter((_, i) => DATA.impactKinds.includes(events.kind[i]));
const main = document.querySelector("main"), left = element("div", undefined, main), side = element("div", undefined, main);
side.append(document.getElementById("readout"));
const shade = (number) => colour("c" + (number % 7));

// value of a curve at an instant
function valueAt(curve, instant) {
  const f = columns[curve.column];
  let i = lowerBound(t, instant);
  if (i >= t.length) return f[t.length - 1];
  if (t[i] === instant || i === 0) { while (i + 1 < t.length && t[i + 1] === instant) i++; return f[i]; }
  return between(curve, i - 1, instant);
}

// between two rows: a displacement by the cubic that has its values and velocities there, a velocity by the
// rate of that cubic, everything else along a line
function between(curve, i, instant) {
  const h = t[i + 1] - t[i], s = h > 0 ? (instant - t[i]) / h : 1;
  const f = columns[curve.of || curve.column], rate = columns[curve.of ? curve.column : curve.rate];
  if (!rate || !(h > 0)) { const own = columns[curve.column]; return own[i] + s * (own[i + 1] - own[i]); }
  const rise = f[i + 1] - f[i], a = h * rate[i] - rise, b = rise - h * rate[i + 1];
  if (curve.of) return (rise + (1 - 2 * s) * ((1 - s) * a + s * b) + s * (1 - s) * (b - a)) / h;
  return (1 - s) * f[i] + s * f[i + 1] + s * (1 - s) * ((1 - s) * a + s * b);
}

function rows(range) {
  return [Math.max(lowerBound(t, range[0]) - 1, 0), Math.min(lowerBound(t, range[1]) + 1, t.length)];
}

function extremes(names, [first, last]) {
  let low = Infinity, high = -Infinity;
  for (const name of names) { const f = columns[name]; for (let i = first; i < last; i++) { if (f[i] < low) low = f[i]; if (f[i] > high) high = f[i]; } }
  return [low, high];
}

// Of the rows that fall into one pixel the first, least, greatest and last: no extreme is lost at any zoom.
// Such a band has no dashes.
function draw(axes, curve, dash, factor, [first, last]) {
  const g = axes.g, f = columns[curve.column], smooth = curve.rate || curve.of;
  g.strokeStyle = shade(curve.colour); g.lineWidth = 1.2; g.beginPath();
  if (last - first > 3 * axes.inner) {
    let column = -1, low = 0, high = 0, end = 0;
    for (let i = first; i < last; i++) {
      const x = Math.floor(axes.px(t[i])), y = f[i];
      if (x !== column) {
        if (column !== -1) { g.lineTo(column, axes.py(low * factor)); g.lineTo(column, axes.py(high * factor)); g.lineTo(column, axes.py(end * factor)); }
        column = x; low = high = y; g.lineTo(x, axes.py(y * factor));
      } else { if (y < low) low = y; if (y > high) high = y; }
      end = y;
    }
    g.lineTo(column, axes.py(low * factor)); g.lineTo(column, axes.py(high * factor));
  } else {
    g.setLineDash(dash);
    g.moveTo(axes.px(t[first]), axes.py(f[first] * factor));
    for (let i = first; i + 1 < last; i++) {
      const steps = smooth ? Math.min(Math.ceil((axes.px(t[i + 1]) - axes.px(t[i])) / 2), 400) : 1;
      for (let k = 1; k < steps; k++) {
        const instant = t[i] + (t[i + 1] - t[i]) * k / steps;
        g.lineTo(axes.px(instant), axes.py(between(curve, i, instant) * factor));
      }
      g.lineTo(axes.px(t[i + 1]), axes.py(f[i + 1] * factor));
    }
  }
  g.stroke(); g.setLineDash([]);
}

const panels = DATA.panels.map((panel, i) => {
  const last = i === DATA.panels.length - 1;
  const axes = new Axes(left, last ? 190 : 172, last ? "time (s)" : "", panel.label, panel.label + " over time");
  return { ...panel, axes };
});
const portrait = new Axes(side, 330, DATA.portrait.xLabel, DATA.portrait.yLabel, "phase portrait of the time that is shown");
let cursor = null, chosen = -1;

function beyond(axes) {
  if (DATA.horizon === null || DATA.horizon >= axes.x[1]) return;
  const g = axes.g, x = Math.max(axes.px(DATA.horizon), axes.left);
  g.fillStyle = colour("beyond"); g.fillRect(x, axes.top, axes.left + axes.inner - x, axes.inside);
  g.strokeStyle = colour("dim"); g.setLineDash([2, 3]); g.beginPath(); g.moveTo(x, axes.top); g.lineTo(x, axes.top + axes.inside); g.stroke(); g.setLineDash([]);
}

function ticksOfImpacts(axes) {
  const g = axes.g, first = lowerBound(impacts, axes.x[0]);
  g.strokeStyle = colour("mark"); g.beginPath();
  let seen = -1;
  for (let i = first; i < impacts.length && impacts[i] <= axes.x[1]; i++) {
    const x = Math.round(axes.px(impacts[i]));
    if (x !== seen) { g.moveTo(x + 0.5, axes.top + axes.inside); g.lineTo(x + 0.5, axes.top + axes.inside - 6); seen = x; }
  }
  g.stroke();
}

function drawPortrait(visible) {
  const [fx, fy] = DATA.portrait.factors, x = columns[DATA.portrait.x], y = columns[DATA.portrait.y];
  const spread = (name, factor) => { const [low, high] = extremes([name], visible); const m = (high - low) * 0.05 || 1e-12; return [(low - m) * factor, (high + m) * factor]; };
  portrait.x = spread(DATA.portrait.x, fx); portrait.y = spread(DATA.portrait.y, fy);
  align([portrait]);
  const g = portrait.begin();
  for (const stop of DATA.portrait.stops) {
    g.strokeStyle = colour("dim"); g.setLineDash([5, 3]); g.beginPath();
    g.moveTo(portrait.px(stop * fx), portrait.top); g.lineTo(portrait.px(stop * fx), portrait.top + portrait.inside); g.stroke(); g.setLineDash([]);
  }
  const [first, last] = visible, step = Math.max(1, Math.floor((last - first) / 60000));
  g.strokeStyle = shade(0); g.globalAlpha = last - first > 3000 ? 0.5 : 1; g.lineWidth = 0.8; g.beginPath();
  const along = { column: "<x>", rate: "<v>" }, across = { column: "<v>", of: "<x>" };
  const between2 = Math.max(1, Math.min(40, Math.floor(12000 / (last - first))));
  for (let i = first; i < last; i += step) {
    g.lineTo(portrait.px(x[i] * fx), portrait.py(y[i] * fy));
    for (let k = 1; k < between2 && i + 1 < last; k++) {
      const instant = t[i] + (t[i + 1] - t[i]) * k / between2;
      g.lineTo(portrait.px(between(along, i, instant) * fx), portrait.py(between(across, i, instant) * fy));
    }
  }
  g.stroke(); g.globalAlpha = 1;
  if (cursor !== null) {
    const at = [valueAt(along, cursor), valueAt(across, cursor)];
    g.fillStyle = colour("mark"); g.beginPath(); g.arc(portrait.px(at[0] * fx), portrait.py(at[1] * fy), 4, 0, 7); g.fill();
  }
  portrait.end();
}

function redraw() {
  const visible = rows(view.range);
  for (const panel of panels) {
    const axes = panel.axes;
    axes.legend = panel.curves.map((curve, i) => [curve.name, shade(curve.colour), panel.curves.length > 1 && dashOf(i)]);
    axes.x = view.range;
    const [low, high] = extremes(panel.curves.map((curve) => curve.column), visible);
    axes.fit(low * panel.factor, high * panel.factor);
  }
  align(panels.map((panel) => panel.axes));
  for (const panel of panels) {
    const axes = panel.axes;
    axes.begin();
    beyond(axes);
    panel.curves.forEach((curve, i) => draw(axes, curve, dashOf(i), panel.factor, visible));
    ticksOfImpacts(axes);
    if (cursor !== null) { const g = axes.g, x = axes.px(cursor); g.strokeStyle = colour("mark"); g.beginPath(); g.moveTo(x, axes.top); g.lineTo(x, axes.top + axes.inside); g.stroke(); }
    axes.end();
  }
  drawPortrait(visible);
  main.dataset.from = view.range[0]; main.dataset.to = view.range[1];
  main.dataset.rows = visible[1] - visible[0];
  main.dataset.impacts = lowerBound(impacts, view.range[1]) - lowerBound(impacts, view.range[0]);
}

function point(instant) {
  cursor = Math.min(Math.max(instant, t[0]), t[t.length - 1]);
  const lines = [["t", shortNumber(cursor) + " s"]];
  for (const panel of panels) for (const curve of panel.curves) lines.push([curve.name, shortNumber(valueAt(curve, cursor) * panel.factor) + " " + panel.unit, shade(curve.colour)]);
  const near = chosen >= 0 ? chosen : -1;
  if (near >= 0) lines.push(["event", DATA.kinds[events.kind[near]] + (events.part[near] >= 0 ? " of " + DATA.parts[events.part[near]] : "")]);
  if (DATA.horizon !== null && cursor > DATA.horizon) lines.push(["", "beyond the trust horizon, " + shortNumber(DATA.horizon) + " s"]);
  tell(lines);
  redraw();
}

function nearest(instant, reach) {
  const i = lowerBound(events.t, instant);
  const sides = [i - 1, i].filter((k) => k >= 0 && k < events.t.length && Math.abs(events.t[k] - instant) <= reach);
  return sides.length ? sides.reduce((a, b) => Math.abs(events.t[a] - instant) <= Math.abs(events.t[b] - instant) ? a : b) : -1;
}

function hover(axes) {
  return (x) => {
    const instant = axes.xAt(x), reach = 6 / axes.inner * (axes.x[1] - axes.x[0]);
    chosen = nearest(instant, reach);
    point(chosen >= 0 ? events.t[chosen] : instant);
  };
}

function hoverPortrait(px, py) {
  const [first, last] = rows(view.range), [fx, fy] = DATA.portrait.factors;
  const x = columns[DATA.portrait.x], y = columns[DATA.portrait.y];
  let best = -1, least = 400;
  for (let i = first; i < last; i++) {
    const dx = portrait.px(x[i] * fx) - px, dy = portrait.py(y[i] * fy) - py, distance = dx * dx + dy * dy;
    if (distance < least) { least = distance; best = i; }
  }
  if (best >= 0) { chosen = nearest(t[best], 0); point(t[best]); }
}

// to the next impact (way 1) or the one before (way -1), a few of its lengths about it
function impact(way) {
  if (!impacts.length) return;
  const from = cursor !== null ? cursor : view.range[0];
  let i = way > 0 ? lowerBound(impacts, from) : lowerBound(impacts, from) - 1;
  if (way > 0 && i < impacts.length && impacts[i] === from) i++;
  i = Math.min(Math.max(i, 0), impacts.length - 1);
  chosen = nearest(impacts[i], 0);
  cursor = impacts[i];
  const length = Math.min(view.range[1] - view.range[0], DATA.impactSpan);
  view.set(impacts[i] - length / 2, impacts[i] + length / 2);
  point(impacts[i]);
}

const view = new View([t[0], t[t.length - 1]], 1e-5 * (t[t.length - 1] - t[0]) / 300, redraw);
buttons([
  ["whole run", "everything (0)", () => view.all()],
  ["+", "closer (+)", () => view.zoom(0.5, cursor === null ? undefined : cursor)],
  ["−", "further (-)", () => view.zoom(2, cursor === null ? undefined : cursor)],
  ["◀ impact", "the impact before (p)", () => impact(-1)],
  ["impact ▶", "the next impact (n)", () => impact(1)],
]);
const toggle = theme(redraw);
const length = () => view.range[1] - view.range[0];
keys({
  ArrowLeft: () => view.pan(-0.2 * length()), ArrowRight: () => view.pan(0.2 * length()),
  ArrowUp: () => view.zoom(0.5, cursor ?? undefined), ArrowDown: () => view.zoom(2, cursor ?? undefined),
  "+": () => view.zoom(0.5, cursor ?? undefined), "-": () => view.zoom(2, cursor ?? undefined),
  "0": () => view.all(), Home: () => view.all(), n: () => impact(1), p: () => impact(-1), d: () => toggle(),
});
for (const panel of panels) listen(panel.axes, view, hover(panel.axes));
portrait.canvas.addEventListener("pointermove", (event) => { const box = portrait.canvas.getBoundingClientRect(); hoverPortrait(event.clientX - box.left, event.clientY - box.top); });
new ResizeObserver(redraw).observe(main);
redraw();
