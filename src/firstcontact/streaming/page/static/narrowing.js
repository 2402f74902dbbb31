// How the estimate narrows over the milliseconds since contact: interval and value, up to the second finger.

import { draw, number } from "./dom.js";

// What is drawn, ms; it is drawn slower than it happened, s, so that an eye can follow.
const LONGEST = 15;
const SHOWN_IN = 0.9;

export class Narrowing {
  constructor(paint) {
    this.repaint = paint;
    this.estimates = [];
    this.still = matchMedia("(prefers-reduced-motion: reduce)");
  }

  clear() {
    this.estimates = [];
    this.contact = null;
  }

  now(now) {
    this.estimates = now.estimates;
    this.second = now.second === null ? null : 1000 * now.second;
    const contact = now.estimates[0].contact.sample;
    if (contact !== this.contact) {
      this.contact = contact;
      this.began = performance.now();
      this.step(contact);
    }
  }

  step(contact) {
    if (contact !== this.contact) return;
    this.repaint();
    if (this.drawing) requestAnimationFrame(() => this.step(contact));
  }

  // So many ms after the contact are drawn by now.
  until() {
    if (this.still.matches || this.began === undefined) return LONGEST;
    return Math.min(LONGEST, ((performance.now() - this.began) / 1000 / SHOWN_IN) * LONGEST);
  }

  // Whether it is still drawn slower than it came.
  get drawing() {
    return this.until() < LONGEST;
  }

  // The last estimate that is drawn; null before the first.
  get shown() {
    const until = this.until();
    return this.estimates.filter((a) => 1000 * a.elapsed <= until + 0.05).at(-1) ?? null;
  }

  paint(svg, left, right, y, scale) {
    const x = (ms) => left + (ms / LONGEST) * (right - left);
    for (const s of scale.ticks) {
      draw(svg, "line", { x1: left, x2: right, y1: y(s), y2: y(s), stroke: "var(--line)" });
    }
    const narrow = x(5) - x(0) < 50;
    for (let ms = 0; ms <= LONGEST; ms += 5) {
      if (narrow && ms === LONGEST - 5) continue;  // its number and the last one would touch
      const anchor = ms === LONGEST ? "end" : "middle";
      const word = ms === LONGEST ? `${ms} ms` : String(ms);
      draw(svg, "text", { x: x(ms) + (ms === LONGEST ? 8 : 0), y: y(scale.low) + 20, "text-anchor": anchor, class: "soft" }, word);
    }
    const until = this.until();
    const estimates = this.estimates.filter((a) => 1000 * a.elapsed <= until + 0.05);
    if (estimates.length > 0) {
      const odd = estimates.at(-1).out_of_range;
      const edge = (key) => estimates.map((a) => `${x(1000 * a.elapsed)} ${y(a[key])}`);
      draw(svg, "path", { d: `M${[...edge("high"), ...edge("low").reverse()].join("L")}Z`, class: odd ? "funnel odd" : "funnel" });
      draw(svg, "path", { d: `M${edge("value").join("L")}`, class: "course" });
      for (const a of estimates) draw(svg, "circle", { cx: x(1000 * a.elapsed), cy: y(a.value), r: 2.5, fill: a.out_of_range ? "var(--bad)" : "var(--accent)" });
      const last = estimates.at(-1);
      draw(svg, "circle", { cx: x(1000 * last.elapsed), cy: y(last.value), r: 5, fill: odd ? "var(--bad)" : "var(--accent)" });
    }
    const { second } = this;
    if (second !== null && second >= 0 && second <= Math.min(LONGEST, until)) {
      const at = x(second);
      draw(svg, "rect", { x: at, y: y(scale.high), width: right - at, height: y(scale.low) - y(scale.high), class: "after" });
      draw(svg, "line", { x1: at, x2: at, y1: y(scale.high), y2: y(scale.low), stroke: "var(--ink)", "stroke-width": 2 });
      const early = second < LONGEST / 2;
      const label = `2nd: ${number(second, 1)} ms`;
      const fits = early || at - x(0) > 8 * label.length;
      draw(svg, "text", { x: at + (early ? 7 : -7), y: y(scale.high) + 14, "text-anchor": early ? "start" : "end" }, fits ? label : "2nd");
    }
  }
}
