"use strict";
// What every page has: its data, colours, ticks, and a canvas with axes. No library, no network.

const DATA = JSON.parse(document.getElementById("data").textContent);
const root = document.documentElement;

function decoded(text, Type) {
  const raw = atob(text), bytes = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i++) bytes[i] = raw.charCodeAt(i);
  return new Type(bytes.buffer);
}

function colour(name) { return getComputedStyle(root).getPropertyValue("--" + name).trim(); }

function element(tag, text, parent) {
  const made = document.createElement(tag);
  if (text !== undefined) made.textContent = text;
  if (parent) parent.append(made);
  return made;
}

// position of the first value that is not below x, of ascending values
function lowerBound(values, x) {
  let low = 0, high = values.length;
  while (low < high) { const middle = (low + high) >> 1; if (values[middle] < x) low = middle + 1; else high = middle; }
  return low;
}

// dashes of the lines of a panel, in turn with the colours: of one line none
const DASHES = [[], [8, 3], [2, 2], [8, 2, 2, 2], [4, 2], [12, 4], [8, 2, 2, 2, 2, 2]];
function dashOf(i) { return DASHES[(i + Math.floor(i / 7)) % DASHES.length]; } // shifted where the seven colours begin again

// as much room for the ticks of all axes as the widest needs: one column of x for panels below each other
function align(list) {
  const left = Math.max(LEFT, ...list.map((axes) => axes.room()));
  for (const axes of list) axes.left = left;
}
const LEFT = 62, ROW = 14, FONT = "11px system-ui, sans-serif"; // ROW: height of a row of the legend

function ticksOf(low, high, most) {
  const rough = (high - low) / Math.max(most, 1), power = Math.pow(10, Math.floor(Math.log10(rough)));
  const step = [1, 2, 5, 10].map((each) => each * power).find((each) => each >= rough * 0.999) || 10 * power;
  const ticks = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; i++) ticks.push(i * step);
  const decimals = Math.max(0, Math.min(12, Math.ceil(-Math.log10(step) - 1e-9)));
  return ticks.map((value) => [value, Math.abs(value) >= 1e6 || (step < 1e-6) ? value.toPrecision(7) : value.toFixed(decimals)]);
}

// ticks of a logarithmic axis, in powers of ten, as [power, text]; as on a linear one where it is short
function powersOf(low, high, most) {
  const ticks = [];
  for (let power = Math.floor(low); power <= high; power++) for (const digit of [1, 2, 5]) {
    const at = power + Math.log10(digit);
    if (at >= low - 1e-9 && at <= high + 1e-9) ticks.push([at, Math.abs(power) >= 5 ? digit + "e" + power : shortNumber(digit * Math.pow(10, power)), digit]);
  }
  if (ticks.length < 2) return ticksOf(Math.pow(10, low), Math.pow(10, high), most).map(([value, text]) => [Math.log10(value), text]);
  if (ticks.length <= most) return ticks;
  const stride = Math.ceil((high - low) / Math.max(most, 1));
  return ticks.filter(([at, , digit]) => digit === 1 && Math.round(at) % stride === 0);
}

function shortNumber(value) {
  if (!Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  return size !== 0 && (size < 1e-4 || size >= 1e6) ? value.toExponential(5) : String(Number(value.toPrecision(7)));
}

// A canvas with a frame, ticks and labels; x and y are its ranges in the units shown, powers of ten on logarithmic axes.
class Axes {
  constructor(parent, height, xLabel, yLabel, spoken) {
    this.canvas = element("canvas", undefined, parent);
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", spoken);
    this.height = height; this.xLabel = xLabel; this.yLabel = yLabel;
    this.x = [0, 1]; this.y = [0, 1]; this.xLog = this.yLog = false;
    this.left = LEFT; this.right = 10; this.bottom = xLabel ? 34 : 18;
    this.legend = []; this.rows = 1; // name, colour and dashes of what is drawn; in so many rows above the frame
  }
  begin() {
    const ratio = window.devicePixelRatio || 1, width = this.canvas.parentElement.clientWidth;
    const g = this.g = this.canvas.getContext("2d");
    this.width = width;
    const places = this._places(g);
    this.height += (places.rows - this.rows) * ROW; this.rows = places.rows;
    this.canvas.width = Math.round(width * ratio); this.canvas.height = Math.round(this.height * ratio);
    this.canvas.style.height = this.height + "px";
    g.setTransform(ratio, 0, 0, ratio, 0, 0);
    g.clearRect(0, 0, width, this.height);
    g.font = FONT; g.lineWidth = 1;
    this._grid(g);
    this._names(g, places);
    g.save(); g.beginPath(); g.rect(this.left, this.top, this.inner, this.inside); g.clip();
    return g;
  }
  get inner() { return Math.max(this.width - this.left - this.right, 10); }
  get top() { return 18 + (this.rows - 1) * ROW; }
  get inside() { return this.height - this.top - this.bottom; }
  px(x) { return this.left + (x - this.x[0]) / (this.x[1] - this.x[0]) * this.inner; }
  py(y) { return this.top + (this.y[1] - y) / (this.y[1] - this.y[0]) * this.inside; }
  xAt(px) { return this.x[0] + (px - this.left) / this.inner * (this.x[1] - this.x[0]); }
  yAt(py) { return this.y[1] - (py - this.top) / this.inside * (this.y[1] - this.y[0]); }
  _ticksUp() { return this.words || (this.yLog ? powersOf : ticksOf)(this.y[0], this.y[1], this.inside / 34); }
  // width of the ticks of y and their label [px]
  room() {
    const g = this.canvas.getContext("2d");
    g.font = FONT;
    return Math.ceil(Math.max(0, ...this._ticksUp().map(([, text]) => g.measureText(text).width))) + 24;
  }
  _grid(g) {
    g.fillStyle = colour("dim"); g.strokeStyle = colour("grid");
    g.textAlign = "center"; g.textBaseline = "top";
    for (const [value, text] of (this.xLog ? powersOf : ticksOf)(this.x[0], this.x[1], this.inner / 90)) {
      const x = this.px(value);
      g.beginPath(); g.moveTo(x, this.top); g.lineTo(x, this.top + this.inside); g.stroke();
      if (this.bottom > 15) g.fillText(text, Math.min(x, this.width - g.measureText(text).width / 2), this.top + this.inside + 4);
    }
    g.textAlign = "right"; g.textBaseline = "middle";
    for (const [value, text] of this._ticksUp()) {
      const y = this.py(value);
      g.beginPath(); g.moveTo(this.left, y); g.lineTo(this.left + this.inner, y); g.stroke();
      g.fillText(text, this.left - 5, y);
    }
    g.textAlign = "center"; g.textBaseline = "alphabetic"; g.fillStyle = colour("ink");
    if (this.xLabel) g.fillText(this.xLabel, this.left + this.inner / 2, this.height - 5);
    g.save(); g.translate(11, this.top + this.inside / 2); g.rotate(-Math.PI / 2); g.fillText(this.yLabel, 0, 0); g.restore();
  }
  end() {
    const g = this.g;
    g.restore();
    g.strokeStyle = colour("frame"); g.strokeRect(this.left, this.top, this.inner, this.inside);
  }
  // places of the names of the legend [px], in as many rows as they need
  _places(g) {
    g.font = FONT;
    const places = [], most = this.width - this.right;
    let x = this.left + 2, row = 0;
    for (const [name, , dash] of this.legend) {
      const long = (dash ? 28 : 0) + g.measureText(name).width;
      if (x + long > most && x > this.left + 2) { x = this.left + 2; row++; }
      places.push([x, 13 + row * ROW]); x += long + 14;
    }
    places.rows = row + 1;
    return places;
  }
  _names(g, places) {
    g.textAlign = "left"; g.textBaseline = "alphabetic";
    this.legend.forEach(([name, shade, dash], i) => {
      const [x, y] = places[i];
      if (dash) { g.strokeStyle = shade; g.lineWidth = 1.6; g.setLineDash(dash); g.beginPath(); g.moveTo(x, y - 4); g.lineTo(x + 24, y - 4); g.stroke(); g.setLineDash([]); }
      g.fillStyle = shade; g.fillText(name, x + (dash ? 28 : 0), y);
    });
    g.lineWidth = 1;
  }
  // a range about the values, with a margin
  fit(low, high) {
    if (!(low <= high)) { low = 0; high = 1; }
    const margin = (high - low) * 0.06 || Math.abs(high) * 0.1 || 1e-12;
    this.y = [low - margin, high + margin];
  }
}

// a row of signs and what they mean, drawn again with the colours of the page
function signs(parent, meaning) {
  const canvas = element("canvas", undefined, parent);
  canvas.setAttribute("role", "img"); canvas.className = "signs";
  const draw = () => {
    const ratio = window.devicePixelRatio || 1, width = parent.clientWidth, list = meaning(), g = canvas.getContext("2d");
    g.font = FONT;
    const places = [];
    let x = 14, y = 9;
    for (const [text] of list) {
      const long = g.measureText(text).width + 42;
      if (x + long > width && x > 14) { x = 14; y += 17; }
      places.push([x, y]); x += long;
    }
    canvas.width = Math.round(width * ratio); canvas.height = Math.round((y + 9) * ratio); canvas.style.height = (y + 9) + "px";
    g.setTransform(ratio, 0, 0, ratio, 0, 0);
    g.font = FONT; g.textBaseline = "middle";
    list.forEach(([text, shade, sign], i) => { const [x, y] = places[i]; sign(g, x, y); g.fillStyle = shade; g.fillText(text, x + 12, y); });
    canvas.setAttribute("aria-label", list.map(([text]) => text).join(", "));
  };
  new ResizeObserver(draw).observe(parent);
  new MutationObserver(draw).observe(root, { attributes: true });
}

// zoom with the wheel, pan by dragging, all again by a double click; the same for every canvas of a page
function listen(axes, view, hover) {
  const canvas = axes.canvas;
  let dragged = null;
  const at = (event) => { const box = canvas.getBoundingClientRect(); return [event.clientX - box.left, event.clientY - box.top]; };
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    view.zoom(Math.pow(1.0018, event.deltaY), axes.xAt(at(event)[0]));
  }, { passive: false });
  canvas.addEventListener("pointerdown", (event) => { dragged = at(event)[0]; canvas.setPointerCapture(event.pointerId); });
  canvas.addEventListener("pointerup", () => { dragged = null; });
  canvas.addEventListener("pointermove", (event) => {
    const [x, y] = at(event);
    if (dragged !== null) { view.pan((dragged - x) / axes.inner * (axes.x[1] - axes.x[0])); dragged = x; } else hover(x, y);
  });
  canvas.addEventListener("dblclick", () => view.all());
}

// the range of x that all panels of a page share
class View {
  constructor(full, least, redraw) { this.full = full; this.least = least; this.redraw = redraw; this.range = [...full]; }
  set(low, high) {
    const [first, last] = this.full;
    const length = Math.min(Math.max(high - low, this.least), last - first);
    const begin = Math.min(Math.max(low, first), last - length);
    this.range = [begin, begin + length];
    this.redraw();
  }
  zoom(factor, about) {
    const [low, high] = this.range, middle = about === undefined ? (low + high) / 2 : about;
    this.set(middle - (middle - low) * factor, middle + (high - middle) * factor);
  }
  pan(distance) { this.set(this.range[0] + distance, this.range[1] + distance); }
  all() { this.set(...this.full); }
}

function buttons(actions) {
  const nav = document.querySelector("nav");
  for (const [text, title, act] of actions) { const made = element("button", text, nav); made.title = title; made.type = "button"; made.onclick = act; }
}

function keys(actions) {
  document.addEventListener("keydown", (event) => {
    if (event.target.tagName === "SELECT" || event.ctrlKey || event.metaKey || event.altKey) return;
    const act = actions[event.key];
    if (act) { event.preventDefault(); act(); }
  });
}

function theme(redraw) {
  const dark = window.matchMedia("(prefers-color-scheme: dark)");
  root.dataset.theme = dark.matches ? "dark" : "light";
  dark.addEventListener("change", () => { root.dataset.theme = dark.matches ? "dark" : "light"; redraw(); });
  buttons([["light / dark", "change the colours (d)", toggle]]);
  function toggle() { root.dataset.theme = root.dataset.theme === "dark" ? "light" : "dark"; redraw(); }
  return toggle;
}

// the readout: rows of label and text, and a command
function tell(rows, command) {
  const box = document.getElementById("readout");
  const table = element("table");
  for (const [label, text, shade] of rows) {
    const line = element("tr", undefined, table), name = element("td", label, line);
    if (shade) name.style.color = shade;
    element("td", text, line);
  }
  box.replaceChildren(table);
  if (command) element("code", command, box);
}
