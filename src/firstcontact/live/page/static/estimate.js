// The estimate with its interval, on a Shore A scale with the objects that are known.

import { FINGER_NAMES, byId, draw, number, setText, size, watch } from "./dom.js";

const PAD = 10;

export class Estimate {
  constructor() {
    this.svg = byId("scale");
    this.landmarks = [];
    this.estimate = null;
    watch(this.svg, () => this.paint());
  }

  hello(hello) {
    this.landmarks = Object.entries(hello.landmarks).sort((a, b) => a[1] - b[1]);
    this.level = null;
    this.clear();
  }

  clear() {
    this.estimate = null;
    setText(byId("value"), "–");
    setText(byId("interval"), "");
    setText(byId("sure"), "");
    setText(byId("felt"), "Waiting for a contact.");
    byId("verdict").hidden = true;
    this.paint();
  }

  now(now) {
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
    setText(byId("felt"), `${FINGER_NAMES[now.finger]} first`);
    const early = now.case === "IN_TIME";
    verdict.className = early ? "verdict good" : "verdict late";
    const used = early && !now.used ? ", not used" : "";
    setText(verdict, (early ? "✓ before the second contact" : "✕ after the second contact") + used);
    verdict.hidden = false;
    this.paint();
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
    const y = (shore) => height - PAD - (Math.min(100, Math.max(0, shore)) / 100) * (height - 2 * PAD);
    const axis = 44;
    this.svg.replaceChildren();
    draw(this.svg, "rect", { x: axis - 4, y: y(100), width: 8, height: y(0) - y(100), rx: 4, fill: "var(--line)" });
    for (let s = 0; s <= 100; s += 20) {
      draw(this.svg, "text", { x: axis - 14, y: y(s) + 5, "text-anchor": "end", class: "soft" }, String(s));
      draw(this.svg, "line", { x1: axis - 10, x2: axis - 4, y1: y(s), y2: y(s), stroke: "var(--soft)" });
    }
    for (const { name, shore, at } of this.places(y, 17, height)) {
      draw(this.svg, "path", { d: `M${axis + 5} ${y(shore)}L${axis + 11} ${y(shore)}L${axis + 19} ${at}`, fill: "none", stroke: "var(--soft)" });
      const label = draw(this.svg, "text", { x: axis + 23, y: at + 5 }, name);
      if (label.getComputedTextLength() > width - axis - 23) {
        label.setAttribute("textLength", width - axis - 23);
        label.setAttribute("lengthAdjust", "spacingAndGlyphs");
      }
    }
    if (!this.estimate) return;
    const { value, low, high } = this.estimate;
    const [top, bottom] = [y(high), y(low)];
    draw(this.svg, "rect", { x: axis - 9, y: top, width: 18, height: Math.max(2, bottom - top), rx: 4, fill: "var(--band)" });
    draw(this.svg, "line", { x1: axis - 12, x2: axis + 12, y1: y(value), y2: y(value), stroke: "var(--accent)", "stroke-width": 5, "stroke-linecap": "round" });
  }
}
