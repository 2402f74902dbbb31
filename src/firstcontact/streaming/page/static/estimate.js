// The estimate with its interval, on the scale of its quantity with the objects that are known.

import { FINGER_NAMES, announce, byId, draw, number, setText, size, watch } from "./dom.js";
import { later, shown } from "./events.js";
import { Narrowing } from "./narrowing.js";
import { figure, learn, quantityOf, scaleOf } from "./quantity.js";

const PAD = 10;
// Room for the names of objects, and for milliseconds below, where an answer narrows.
const NAMES = 128;
const BELOW = 28;

// Verdict of a finished pinch: look and words.
function judgement(pinch, estimate) {
  const second = pinch.offset === null ? "second finger not detected" : `second finger after ${number(1000 * pinch.offset, 1)} ms`;
  const after = `${number(1000 * estimate.available, 1)} ms`;
  if (pinch.verdict === "in_time") return ["good", `✓ in time: estimate after ${after}, ${second}`];
  if (pinch.verdict === "too_late") return ["late", `✕ too late: estimate after ${after}, ${second}`];
  return ["none", "In time? Unknown: this is not real time"];
}

function spoken(now) {
  const estimate = shown(now);
  if (!estimate) return `no estimate: ${now.missing?.reason ?? now.pinch.reason}`;
  const { value, low, high, out_of_range: strange } = estimate, quantity = quantityOf(estimate);
  const ends = high > low ? `, between ${figure(low, quantity)} and ${figure(high, quantity)}` : "";
  return `${figure(value, quantity)} ${quantity.unit}${ends}${strange ? ", out of range" : ""}`;
}

export class Estimate {
  constructor() {
    this.svg = byId("scale");
    this.landmarks = [];
    this.quantity = { name: "shore_a" };
    this.estimate = null;
    this.narrowing = new Narrowing(() => this.paint());
    watch(this.svg, () => this.paint());
  }

  hello(hello) {
    learn(hello);
    this.quantity = quantityOf(hello);
    setText(byId("unit"), this.quantity.unit);
    const familiar = Object.entries(hello.familiar).filter(([name]) => this.quantity.name === "shore_a" && !(name in hello.landmarks));
    this.landmarks = [...Object.entries(hello.landmarks), ...familiar.map((entry) => [...entry, "soft"])].sort((a, b) => a[1] - b[1]);
    // A single sensor has no second contact to be in time for.
    this.alone = hello.fingers.length < 2;
    this.announced = null;
    this.clear();
    this.object(null);
    byId("same").hidden = !hello.controls;
    byId("new-object").hidden = !hello.controls;
    byId("shape-form").hidden = !hello.uses_shape;
  }

  clear() {
    this.estimate = null;
    setText(byId("value"), "–");
    setText(byId("interval"), "");
    setText(byId("sure"), "");
    setText(byId("felt"), "Waiting for a contact.");
    for (const id of ["verdict", "strange", "later"]) byId(id).hidden = true;
    this.narrowing.clear();
    this.paint();
  }

  now(now) {
    this.object(now.object);
    if (!now.contact) {
      this.clear();  // the contact was withdrawn
      return;
    }
    if (now.pinch && now.pinch.number !== this.announced) {
      this.announced = now.pinch.number;
      announce(`Pinch ${now.pinch.number}: ${spoken(now)}`);
    }
    const verdict = byId("verdict");
    if (now.missing) {
      this.clear();
      setText(byId("felt"), `${FINGER_NAMES[now.missing.contact.finger ?? 2]} touched first`);
      verdict.className = "verdict none";
      setText(verdict, `No estimate: ${now.missing.reason}`);
      verdict.hidden = false;
      return;
    }
    const estimate = shown(now);
    // Between a contact and its estimate the last one stays: it is 15 ms.
    if (!estimate) return;
    const { value, low, high, level } = estimate;
    this.estimate = estimate;
    this.quantity = quantityOf(estimate);
    const say = (part) => figure(part, this.quantity);
    setText(byId("value"), say(value));
    setText(byId("unit"), this.quantity.unit);
    const modulus = estimate.modulus_mpa === null ? "" : ` · ${estimate.modulus_mpa.toPrecision(2)} MPa`;
    setText(byId("interval"), `${high > low ? `between ${say(low)} and ${say(high)}` : "no interval"}${modulus}`);
    setText(byId("sure"), level > 0 ? `correct for ${number(100 * level)} % of touches like those in training` : "");
    const shape = estimate.shape ? ` · shape: ${estimate.shape}` : "";
    setText(byId("felt"), `${FINGER_NAMES[estimate.contact.finger ?? 2]} touched first · from ${number(1000 * estimate.elapsed)} ms of signal${shape}`);
    byId("strange").hidden = !estimate.out_of_range;
    // Until the pinch is over there is no verdict.
    const [look, words] = now.pinch ? judgement(now.pinch, estimate) : ["none", ""];
    verdict.className = `verdict ${look}`;
    setText(verdict, words);
    verdict.hidden = !now.pinch || this.alone;
    const late = now.pinch?.verdict === "in_time" ? later(now.pinch) : null;
    byId("later").hidden = !late;
    if (late) setText(byId("later"), `With more signal, after ${number(1000 * late.available, 1)} ms: ${say(late.value)} (${say(late.low)} to ${say(late.high)})`);
    const fan = now.estimates.length > 1;
    this.svg.parentElement.classList.toggle("fan", fan);
    if (fan) this.narrowing.now(now);
    else this.narrowing.clear();
    this.paint();
  }

  // The combined estimate of all pinches of one object; nothing while the next pinch lasts.
  object(object) {
    const { pinches, value, low, high, is_named: named } = object ?? {};
    if (object) byId("same").hidden = false;
    const combined = pinches > 1;
    const single = named ? "One pinch of this object so far" : "Press New object to combine the next pinches";
    setText(byId("same-word"), combined ? `Same object, ${pinches} pinches` : single);
    setText(byId("same-value"), combined ? `${number(value)} Shore A` : "");
    setText(byId("same-interval"), combined ? `${number(low)} to ${number(high)}` : "");
  }

  // Labels stand at their values, pushed apart where they would touch.
  places(y, least, height) {
    const rows = this.landmarks.map(([name, value, look = ""]) => ({ name, value, look, at: y(value) }));
    rows.reverse();
    // Where not all can be named, those closest to another are not: familiar objects first.
    while (rows.length > (height - 2 * PAD) / least + 1) {
      const gap = (i) => Math.min(...[i - 1, i + 1].filter((k) => rows[k]).map((k) => Math.abs(rows[k].value - rows[i].value)));
      const all = [...rows.keys()], familiar = all.filter((i) => rows[i].look);
      rows.splice((familiar.length ? familiar : all.slice(1)).reduce((a, b) => (gap(b) < gap(a) ? b : a)), 1);
    }
    let before = -Infinity;
    for (const row of rows) before = row.at = Math.max(row.at, before + least, PAD);
    let after = Infinity;
    for (const row of rows.reverse()) after = row.at = Math.min(row.at, after - least, height - PAD);
    return rows;
  }

  paint() {
    const [width, height] = size(this.svg);
    if (!width || !height) return;
    const fan = this.narrowing.estimates.length > 0;
    const bottom = fan ? BELOW : PAD;
    const values = [...this.landmarks.map((entry) => entry[1]), ...(this.estimate ? [this.estimate.low, this.estimate.high] : [])];
    const scale = scaleOf(this.quantity, values);
    const y = (value) => height - bottom - Math.min(1, Math.max(0, scale.place(value))) * (height - bottom - PAD);
    const axis = fan ? Math.max(120, width - NAMES - 23) : 44;
    const start = fan ? 0 : axis - 44;
    this.svg.replaceChildren();
    draw(this.svg, "rect", { x: axis - 4, y: y(scale.high), width: 8, height: y(scale.low) - y(scale.high), rx: 4, fill: "var(--line)" });
    for (const s of scale.ticks) {
      draw(this.svg, "text", { x: start + 30, y: y(s) + 5, "text-anchor": "end", class: "soft" }, String(s));
      if (!fan) draw(this.svg, "line", { x1: axis - 10, x2: axis - 4, y1: y(s), y2: y(s), stroke: "var(--soft)" });
    }
    if (fan) this.narrowing.paint(this.svg, start + 42, axis - 22, y, scale);
    for (const { name, value, look, at } of this.places(y, 17, height)) {
      draw(this.svg, "path", { d: `M${axis + 5} ${y(value)}L${axis + 11} ${y(value)}L${axis + 19} ${at}`, fill: "none", stroke: "var(--soft)" });
      const label = draw(this.svg, "text", { x: axis + 23, y: at + 5, class: look }, name);
      if (label.getComputedTextLength() > width - axis - 23) {
        label.setAttribute("textLength", width - axis - 23);
        label.setAttribute("lengthAdjust", "spacingAndGlyphs");
      }
    }
    if (!this.estimate) return;
    // While it is drawn slower than it came, the scale shows what is drawn.
    const { value, low, high } = (fan && this.narrowing.drawing ? this.narrowing.shown : this.estimate) ?? this.estimate;
    const [top, least] = [y(high), y(low)];
    draw(this.svg, "rect", { x: axis - 9, y: top, width: 18, height: Math.max(2, least - top), rx: 4, fill: "var(--band)" });
    draw(this.svg, "line", { x1: axis - 12, x2: axis + 12, y1: y(value), y2: y(value), stroke: "var(--accent)", "stroke-width": 5, "stroke-linecap": "round" });
  }
}
