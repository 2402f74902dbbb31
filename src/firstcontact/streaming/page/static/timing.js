// Where the time from contact to estimate went, against the mean time to the second contact.

import { byId, draw, make, number, setText, size, textWidth, watch } from "./dom.js";
import { parts, shown } from "./events.js";
import { upTo } from "./ticks.js";

const PARTS = [["window", "Signal used"], ["wait", "Waiting"], ["transport", "Transfer"], ["compute", "Computation"]];

export class Timing {
  constructor() {
    this.svg = byId("bar");
    this.values = {};
    this.tree = {};
    for (const [part, name] of PARTS) {
      const row = make("div");
      this.values[part] = make("dd", "", "–");
      row.append(make("dt", part, name), this.values[part]);
      byId("times").append(row);
    }
    this.onHand = null;
    watch(this.svg, () => this.paint());
  }

  // The predictions of a device for its last pinch; null once the next one begins.
  hand(pinch) {
    const final = pinch?.final;
    byId("hand-times").hidden = !final;
    this.onHand = null;
    if (final) {
      const [total, compute] = [1000 * final.available, 1000 * final.compute];
      this.onHand = { signal: total - compute, compute };
      setText(byId("hand-total"), `${number(total, 2)} ms`);
      setText(byId("hand-parts"), `${number(total - compute, 2)} ms of signal, ${number(compute, 2)} ms computation`);
    }
    this.paint();
  }

  hello(hello) {
    this.budget = hello.budget_ms;
    this.now({ estimates: [] });
  }

  now(now) {
    // A touch alone keeps the last picture until its own estimate is there; without a contact, it was withdrawn.
    const estimate = shown(now);
    if (now.contact && !estimate && !now.missing) return;
    const timing = estimate ? parts(estimate) : null;
    this.tree = { timing, second: now.second == null ? null : 1000 * now.second };
    for (const [part] of PARTS) setText(this.values[part], timing ? `${number(timing[part], 2)} ms` : "–");
    setText(byId("total"), timing ? `${number(timing.total, 2)} ms` : "–");
    this.paint();
  }

  paint() {
    const [width, height] = size(this.svg);
    if (!width || !this.budget) return;
    const { timing, second } = this.tree;
    // Room for both moments, as far as that leaves the rest readable.
    const last = Math.max(timing?.total ?? 0, Math.min(second ?? 0, 60), 29);
    const [left, right, top, bottom] = [8, width - 8, 44, height - 48];
    const named = (ms) => (ms === 0 ? "0" : `${number(ms)} ms`);
    const [step, most] = upTo(last + 1, 10, right - left, (ms) => textWidth(this.svg, named(ms)));
    const x = (ms) => left + (Math.min(ms, most) / most) * (right - left);
    this.svg.replaceChildren();
    draw(this.svg, "rect", { x: left, y: top, width: right - left, height: bottom - top, rx: 5, fill: "var(--page)", stroke: "var(--line)" });
    // The hand's own below this computer's, where there is one.
    const between = this.onHand ? Math.round(top + 0.5 * (bottom - top)) : bottom;
    const bar = (parts, from, to, named) => {
      let at = 0;
      for (const [part, ms] of parts) {
        const wide = Math.max(part === "compute" ? 3 : 0, x(at + ms) - x(at));
        draw(this.svg, "rect", { x: x(at), y: from, width: wide, height: to - from, fill: `var(--seg-${part})` });
        at += ms;
      }
      if (named) draw(this.svg, "text", { x: left + 8, y: (from + to) / 2 + 5, class: "inside" }, named);
    };
    if (timing) bar(PARTS.map(([part]) => [part, timing[part]]), top, between, this.onHand ? "here" : "");
    if (this.onHand) {
      const { signal, compute } = this.onHand;
      bar([["window", signal], ["compute", compute]], between + 2, bottom, "hand");
    }
    const line = x(this.budget);
    draw(this.svg, "line", { x1: line, x2: line, y1: top - 10, y2: bottom + 5, stroke: "var(--ink)", "stroke-width": 2, "stroke-dasharray": "5 4" });
    this.label(line, 16, "on average", `${this.budget} ms`, width);
    if (second !== undefined && second !== null) {
      const there = x(second);
      draw(this.svg, "path", { d: `M${there - 7} ${top - 11}h14l-7 12z`, fill: "var(--ink)" });
      draw(this.svg, "line", { x1: there, x2: there, y1: top, y2: bottom, stroke: "var(--ink)", "stroke-width": 3 });
      this.label(there, height - 3, "this time", `${number(second, 1)} ms`, width);
    } else if (timing) {
      draw(this.svg, "text", { x: right, y: height - 3, "text-anchor": "end", class: "soft" }, "second finger: not detected");
    }
    for (let ms = 0; ms <= most; ms += step) {
      const anchor = ms === 0 ? "start" : ms === most ? "end" : "middle";
      draw(this.svg, "text", { x: x(ms) + (ms === 0 ? -4 : ms === most ? 4 : 0), y: bottom + 20, "text-anchor": anchor, class: "soft tick" }, named(ms));
    }
  }

  // When the second finger touched: a label at a place, kept inside the picture.
  label(at, y, which, when, width) {
    const texts = [`second finger ${which}, ${when}`, `2nd finger ${which}, ${when}`, `2nd, ${when}`];
    const text = texts.find((text) => textWidth(this.svg, text) <= width - 4) ?? when;
    const half = textWidth(this.svg, text) / 2;
    const x = Math.min(Math.max(at, half + 2), width - half - 2);
    draw(this.svg, "text", { x, y, "text-anchor": "middle", fill: "var(--ink)" }, text);
  }
}
