"use strict";
// The page of a moving machine: its shapes follow a few channels; beside it portrait and history.

const values = decoded(DATA.values, Float32Array), lit = decoded(DATA.lit, Int8Array);
const xs = decoded(DATA.portrait.x, Float32Array), ys = decoded(DATA.portrait.y, Float32Array);
const curves = DATA.history.curves.map((curve) => ({ ...curve, values: decoded(curve.data, Float32Array) }));
const main = document.querySelector("main"), left = element("div", undefined, main), side = element("div", undefined, main);
side.append(document.getElementById("readout"));
const stage = element("canvas", undefined, left);
stage.setAttribute("role", "img"); stage.setAttribute("aria-label", "the machine, moving"); stage.style.cursor = "default";
const history_ = new Axes(left, 210, "time (s)", DATA.history.label, "displacements over time");
const portrait = new Axes(side, 300, DATA.portrait.xLabel, DATA.portrait.yLabel, "phase portrait");
const end = DATA.begin + DATA.step * (DATA.count - 1);
let now = DATA.begin, speed = DATA.speed, going = false, last = 0;

function bounds(list) { let low = Infinity, high = -Infinity; for (const f of list) for (const v of f) { if (v < low) low = v; if (v > high) high = v; } return [low, high]; }

// position among the instants: the one before, and how far on to the next
function place() {
  const along = Math.min(Math.max((now - DATA.begin) / DATA.step, 0), DATA.count - 1), i = Math.min(Math.floor(along), Math.max(DATA.count - 2, 0));
  return [i, DATA.count > 1 ? along - i : 0];
}

function mixed(f, i, s, stride = 1, offset = 0) {
  const a = f[i * stride + offset], b = f[Math.min(i + 1, DATA.count - 1) * stride + offset];
  return a + s * (b - a);
}

// the paper's colours are those of the still drawing; on dark paper what is light and dark change places
function ink(hex) {
  if (root.dataset.theme !== "dark") return hex;
  const parts = [1, 3, 5].map((k) => parseInt(hex.slice(k, k + 2), 16)), grey = Math.max(...parts) - Math.min(...parts) < 12;
  return grey ? `rgb(${parts.map((part) => Math.round(235 - part * 0.82)).join(",")})` : `rgb(${parts.map((part) => Math.round(part * 0.75 + 64)).join(",")})`;
}

function drawStage(i, s) {
  const [x0, y0, x1, y1] = DATA.frame, width = left.clientWidth, ratio = window.devicePixelRatio || 1;
  const scale = Math.min(width / (x1 - x0), 420 / (y1 - y0)), height = scale * (y1 - y0);
  stage.width = Math.round(width * ratio); stage.height = Math.round(height * ratio); stage.style.height = height + "px";
  const g = stage.getContext("2d");
  g.setTransform(ratio, 0, 0, ratio, 0, 0); g.clearRect(0, 0, width, height);
  const shift = (width - scale * (x1 - x0)) / 2, px = (x) => shift + (x - x0) * scale, py = (y) => (y1 - y) * scale, thick = scale / 28;
  const channel = []; for (let c = 0; c < DATA.channels; c++) channel.push(mixed(values, i, s, DATA.channels, c));
  const on = new Set(DATA.stops.filter((_, k) => lit[i * DATA.stops.length + k]));
  for (const shape of DATA.shapes) {
    const at = shape.at.slice();
    for (const [c, by] of shape.moved) for (let k = 0; k < at.length; k++) at[k] += by[k] * channel[c];
    if (shape.kind === "text") {
      g.font = `${shape.style || ""} ${shape.weight || ""} ${Math.max(shape.size * thick, 7)}px system-ui, sans-serif`;
      g.fillStyle = ink(shape.colour); g.textAlign = shape.ha === "left" ? "left" : "center"; g.textBaseline = "middle";
      g.fillText(shape.text, px(at[0]), py(at[1]));
      continue;
    }
    const struck = on.has(shape.key);
    g.beginPath();
    for (let k = 0; k < at.length; k += 2) g.lineTo(px(at[k]), py(at[k + 1]));
    if (shape.kind === "area" && shape.fill) { g.fillStyle = ink(shape.hatch ? "#c4c4c4" : shape.fill); g.fill(); }
    g.strokeStyle = struck ? "#ffb000" : ink(shape.colour); g.lineWidth = Math.max(shape.width * thick * (struck ? 2.2 : 1), 0.6);
    g.setLineDash(shape.dash ? [4 * thick, 3 * thick] : []); g.lineJoin = "round";
    if (shape.width) g.stroke();
  }
  g.setLineDash([]);
  main.dataset.struck = [...on].join(" ");
}

function drawAxes(i, s) {
  history_.legend = curves.map((curve, k) => [curve.name, colour("c" + (k % 7)), curves.length > 1 && dashOf(k)]);
  history_.x = [DATA.begin, end]; history_.fit(...historyRange); align([history_]);
  const g = history_.begin();
  curves.forEach((curve, k) => {
    g.strokeStyle = colour("c" + (k % 7)); g.lineWidth = 1.1; g.setLineDash(dashOf(k)); g.beginPath();
    for (let n = 0; n < DATA.count; n++) g.lineTo(history_.px(DATA.begin + n * DATA.step), history_.py(curve.values[n]));
    g.stroke(); g.setLineDash([]);
  });
  g.strokeStyle = colour("mark"); g.beginPath(); g.moveTo(history_.px(now), history_.top); g.lineTo(history_.px(now), history_.top + history_.inside); g.stroke();
  history_.end();
  portrait.x = portraitRange[0]; portrait.y = portraitRange[1]; align([portrait]);
  const p = portrait.begin();
  for (const stop of DATA.portrait.stops) { p.strokeStyle = colour("dim"); p.setLineDash([5, 3]); p.beginPath(); p.moveTo(portrait.px(stop), portrait.top); p.lineTo(portrait.px(stop), portrait.top + portrait.inside); p.stroke(); p.setLineDash([]); }
  p.strokeStyle = colour("c0"); p.lineWidth = 0.8; p.beginPath();
  for (let n = 0; n < DATA.count; n++) p.lineTo(portrait.px(xs[n]), portrait.py(ys[n]));
  p.stroke();
  p.fillStyle = colour("mark"); p.beginPath(); p.arc(portrait.px(mixed(xs, i, s)), portrait.py(mixed(ys, i, s)), 5, 0, 7); p.fill();
  portrait.end();
}

function margin([low, high]) { const m = (high - low) * 0.06 || 1e-9; return [low - m, high + m]; }
const historyRange = bounds(curves.map((curve) => curve.values)), portraitRange = [margin(bounds([xs])), margin(bounds([ys]))];

function redraw() {
  const [i, s] = place();
  drawStage(i, s); drawAxes(i, s);
  slider.value = String(now);
  tell([["t", now.toFixed(DATA.decimals) + " s"], ["speed", speed === 1 ? "real time" : shortNumber(Math.max(speed, 1 / speed)) + (speed < 1 ? " times slower" : " times faster")],
    ...curves.map((curve, k) => [curve.name, shortNumber(mixed(curve.values, i, s)) + " " + DATA.history.unit, colour("c" + (k % 7))])]);
  main.dataset.now = now; main.dataset.going = going; main.dataset.speed = speed;
}

function tick(stamp) {
  if (!going) return;
  now += Math.min((stamp - last) / 1000, 0.1) * speed; last = stamp;
  if (now > end) now = DATA.begin;
  redraw();
  requestAnimationFrame(tick);
}

function go() { going = !going; if (going) requestAnimationFrame((stamp) => { last = stamp; tick(stamp); }); redraw(); }
function step(way) { now = Math.min(Math.max(now + way * Math.max(DATA.step, speed / 60), DATA.begin), end); redraw(); }
function faster(factor) { speed = Math.min(Math.max(speed * factor, Math.min(DATA.speed, 1) / 1024), Math.max(DATA.speed, 1) * 64); redraw(); }
function begin() { now = DATA.begin; redraw(); }

buttons([["▶ / ❚❚", "go or stop (space)", go], ["slower", "(-)", () => faster(0.5)], ["faster", "(+)", () => faster(2)], ["start", "from the beginning (0)", begin]]);
const toggle = theme(redraw);
const slider = element("input", undefined, document.querySelector("nav"));
Object.assign(slider, { type: "range", min: DATA.begin, max: end, step: "any", ariaLabel: "time" });
slider.style.flex = "1 1 12em";
slider.addEventListener("input", () => { now = Number(slider.value); redraw(); });
const jump = (event) => { const box = history_.canvas.getBoundingClientRect(); now = Math.min(Math.max(history_.xAt(event.clientX - box.left), DATA.begin), end); redraw(); };
history_.canvas.addEventListener("pointerdown", jump);
history_.canvas.addEventListener("pointermove", (event) => { if (event.buttons) jump(event); });
keys({ " ": go, ArrowLeft: () => step(-1), ArrowRight: () => step(1), "+": () => faster(2), "-": () => faster(0.5), "0": begin, Home: begin, d: () => toggle() });
new ResizeObserver(redraw).observe(main);
redraw();
if (!window.matchMedia("(prefers-reduced-motion: reduce)").matches) go();
