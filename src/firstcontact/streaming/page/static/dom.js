// Small helpers: nothing is written that is already there, so that nothing is laid out for nothing.

// The last is a sensor that belongs to no finger.
export const FINGERS = ["index", "thumb", "index"];
export const FINGER_NAMES = ["Index finger", "Thumb", "Sensor"];

export const byId = (id) => document.getElementById(id);

export function setText(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

// Said by screen readers; the same words are not said again.
export const announce = (text) => setText(byId("spoken"), text);

export function make(name, className = "", text = "") {
  const element = document.createElement(name);
  if (className) element.className = className;
  if (text) element.textContent = text;
  return element;
}

export function draw(parent, name, attributes, text = "") {
  const element = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  if (text) element.textContent = text;
  parent.append(element);
  return element;
}

// How wide a text is in a picture, px.
export function textWidth(svg, text) {
  const drawn = draw(svg, "text", {}, text);
  const width = drawn.getComputedTextLength();
  drawn.remove();
  return width;
}

// A number for people: a proper minus sign, thin spaces between thousands; a dash for none.
export function number(value, digits = 0) {
  if (value === null) return "–";
  const [whole, part] = Math.abs(value).toFixed(digits).split(".");
  const grouped = whole.replace(/\B(?=(\d{3})+$)/g, "\u202f");
  return (value < 0 ? "\u2212" : "") + grouped + (part ? "." + part : "");
}

// A signed number with as many digits as it needs.
export function volts(value) {
  const digits = Math.min(3, (String(Math.abs(value)).split(".")[1] ?? "").length);
  return (value > 0 ? "+" : "") + number(value, digits);
}

const colours = {};
export function readColours() {
  const style = getComputedStyle(document.documentElement);
  for (const name of ["ink", "soft", "line", "index", "thumb", "window", "card"]) {
    colours[name] = style.getPropertyValue("--" + name).trim();
  }
}
export const colour = (name) => colours[name];

// The drawing context of a canvas in CSS pixels, cleared; sharp on any screen.
// Sizes are told by an observer: asking the element would lay out the page at every frame.
const sizes = new Map();
const observer = new ResizeObserver((entries) => {
  for (const e of entries) sizes.set(e.target, [e.contentRect.width, e.contentRect.height]);
});
export function watch(element, changed = null) {
  sizes.set(element, [element.clientWidth, element.clientHeight]);
  observer.observe(element);
  if (changed) new ResizeObserver(changed).observe(element);
}
export const size = (element) => sizes.get(element);
export function context(canvas) {
  const [width, height] = sizes.get(canvas);
  const ratio = Math.min(window.devicePixelRatio || 1, 3);
  const [w, h] = [Math.round(width * ratio), Math.round(height * ratio)];
  if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [w, h];
  const pen = canvas.getContext("2d");
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, width, height);
  pen.lineJoin = "round";
  return [pen, width, height];
}

// Font of canvas text, as large as the page's own.
export function font(rem = 0.875, weight = 400) {
  const base = parseFloat(getComputedStyle(document.documentElement).fontSize);
  return `${weight} ${Math.round(rem * base)}px system-ui, "DejaVu Sans", sans-serif`;
}

const STEPS = [0.02, 0.05, 0.1, 0.2, 0.4, 0.6, 1, 1.6, 2, 5, 10, 20, 50, 100, 1000, 1e9];
// The next full value above a peak.
export const niceAbove = (peak) => STEPS.find((step) => step >= peak);
