// The estimate with its interval, on a Shore A scale with the objects that are known.

import { FINGER_NAMES, byId, draw, number, setText, size, watch } from "./dom.js";
import { Narrowing } from "./narrowing.js";

const PAD = 10;
// Room for the names of objects, and for milliseconds below, where an answer narrows.
const NAMES = 128;
const BELOW = 28;

// What a pinch says of its time once it is over: look and words.
function judgement({ case: verdict, ms, offset, later }) {
  const second = offset === null ? "no second finger heard" : `second finger after ${number(offset, 1)} ms`;
  if (verdict === "IN_TIME") return ["good", `✓ in time: there after ${number(ms, 1)} ms, ${second}`];
  if (verdict === "TOO_LATE") return ["late", `✕ none in time: this one after ${number(later.ms, 1)} ms, ${second}`];
  return ["none", "In time? Not known: samples do not come in real time"];
}

export class Estimate {
  constructor() {
    this.svg = byId("scale");
    this.landmarks = [];
    this.estimate = null;
    this.narrowing = new Narrowing(() => this.paint());
    watch(this.svg, () => this.paint());
  }

  hello(hello) {
    this.landmarks = Object.entries(hello.landmarks).sort((a, b) => a[1] - b[1]);
    // A single sensor has no second contact to be in time for.
    this.alone = hello.fingers.length < 2;
    this.clear();
    byId("same").hidden = true;
    byId("new-object").hidden = !hello.controls;
    byId("shape-form").hidden = !hello.shapes;
  }

  clear() {
    this.estimate = null;
    setText(byId("value"), "–");
    setText(byId("interval"), "");
    setText(byId("sure"), "");
    setText(byId("felt"), "Waiting for a contact.");
    for (const id of ["verdict", "strange", "window-model", "later"]) byId(id).hidden = true;
    this.narrowing.clear();
    this.paint();
  }

  now(now) {
    this.same(now.same);
    const verdict = byId("verdict");
    if (now.refused) {
      this.clear();
      setText(byId("felt"), `${FINGER_NAMES[now.finger]} first`);
      verdict.className = "verdict none";
      setText(verdict, `No estimate: ${now.refused}`);
      verdict.hidden = false;
      return;
    }
    // Between a contact and its estimate the last one stays: it is 15 ms.
    if (!now.estimate) return;
    const { value, low, high, level } = now.estimate;
    this.estimate = now.estimate;
    setText(byId("value"), number(value, 0));
    setText(byId("interval"), high > low ? `${number(low)} to ${number(high)}` : "no interval");
    // What it promises, and for what: other things lie outside far more often.
    setText(byId("sure"), level > 0 ? `${number(100 * level)} % on things like those learned` : "");
    const heard = now.heard ? ` · ${number(now.heard)} ms heard` : "";
    const told = now.told ? ` · told: ${now.told}` : "";
    setText(byId("felt"), `${FINGER_NAMES[now.finger]} first${heard}${told}`);
    byId("strange").hidden = !now.strange;
    // Until the pinch is over, nothing is said of how it went.
    const [look, words] = now.judged ? judgement(now) : ["none", ""];
    verdict.className = `verdict ${look}`;
    setText(verdict, words);
    verdict.hidden = !now.judged || this.alone;
    const later = byId("later");
    later.hidden = !(now.case === "IN_TIME" && now.later);
    if (!later.hidden) setText(later, `Later, after ${number(now.later.ms, 1)} ms: ${number(now.later.value)} (${number(now.later.low)} to ${number(now.later.high)})`);
    const beside = byId("window-model");
    beside.hidden = !now.window;
    if (now.window) setText(beside, `Model of ${number(now.window_ms)} ms: ${number(now.window.value)} (${number(now.window.low)} to ${number(now.window.high)})`);
    this.svg.parentElement.classList.toggle("fan", Boolean(now.answers));
    if (now.answers) this.narrowing.now(now);
    else this.narrowing.clear();
    this.paint();
  }

  // What the pinches of one object say together.
  same(same) {
    byId("same").hidden = !same;
    if (!same) return;
    const { pinches, value, low, high, told } = same;
    const which = pinches > 1 ? `Same object, ${pinches} pinches` : "New object, 1 pinch";
    setText(byId("same-word"), told ? which : "This pinch alone (New object combines the next ones)");
    setText(byId("same-value"), `${number(value)} Shore A`);
    setText(byId("same-interval"), `${number(low)} to ${number(high)}`);
  }

  // Labels stand at their values, pushed apart where they would touch.
  places(y, least, height) {
    const rows = this.landmarks.map(([name, shore]) => ({ name, shore, at: y(shore) }));
    rows.reverse();
    // Where not all can be named, those closest to another are not.
    while (rows.length > (height - 2 * PAD) / least + 1) {
      const gaps = rows.slice(1).map((row, i) => rows[i].shore - row.shore);
      rows.splice(gaps.indexOf(Math.min(...gaps)) + 1, 1);
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
    const fan = this.narrowing.answers.length > 0;
    const bottom = fan ? BELOW : PAD;
    const y = (shore) => height - bottom - (Math.min(100, Math.max(0, shore)) / 100) * (height - bottom - PAD);
    const axis = fan ? Math.max(120, width - NAMES - 23) : 44;
    const start = fan ? 0 : axis - 44;
    this.svg.replaceChildren();
    draw(this.svg, "rect", { x: axis - 4, y: y(100), width: 8, height: y(0) - y(100), rx: 4, fill: "var(--line)" });
    for (let s = 0; s <= 100; s += 20) {
      draw(this.svg, "text", { x: start + 30, y: y(s) + 5, "text-anchor": "end", class: "soft" }, String(s));
      if (!fan) draw(this.svg, "line", { x1: axis - 10, x2: axis - 4, y1: y(s), y2: y(s), stroke: "var(--soft)" });
    }
    if (fan) this.narrowing.paint(this.svg, start + 42, axis - 22, y);
    for (const { name, shore, at } of this.places(y, 17, height)) {
      draw(this.svg, "path", { d: `M${axis + 5} ${y(shore)}L${axis + 11} ${y(shore)}L${axis + 19} ${at}`, fill: "none", stroke: "var(--soft)" });
      const label = draw(this.svg, "text", { x: axis + 23, y: at + 5 }, name);
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
