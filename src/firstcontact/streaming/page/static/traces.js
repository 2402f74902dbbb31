// Both traces, scrolling: each column is a stroke from its least to its greatest sample.

import { FINGERS, FINGER_NAMES, colour, context, font, niceAbove, number, volts, watch } from "./dom.js";
import { apart } from "./ticks.js";
import { Ring } from "./ring.js";

const BOTTOM = 26;
const TOP = 18;
// The picture stays this far behind what came, so that it scrolls evenly, s.
const BEHIND = 0.06;

export class Traces {
  constructor(canvas) {
    this.canvas = canvas;
    this.ring = null;
    this.marks = [];
    this.came = 0;
    watch(canvas);
  }

  hello(hello) {
    this.perSecond = hello.rate / hello.column_samples;
    this.shown = Math.ceil(hello.seconds * this.perSecond);
    this.seconds = hello.seconds;
    this.fingers = hello.fingers;
    this.unit = hello.unit;
    for (const item of document.querySelectorAll(".legend [data-finger]")) {
      item.hidden = !hello.fingers.includes(Number(item.dataset.finger));
    }
    this.ring = new Ring(Math.ceil(this.shown * 1.25), hello.fingers.length);
    this.marks = [];
    this.head = null;
    // The noise of a fingertip at rest stays small on the scale.
    this.least = this.unit === "V" ? 0.1 : 0.02;
    this.range = this.least;
    this.came = 0;
  }

  columns(first, n, values) {
    this.ring.add(first, n, values);
    this.came = performance.now();
  }

  // Seconds since samples came, or null when none ever did.
  silent(now) {
    return this.came ? (now - this.came) / 1000 : null;
  }

  // Let the right edge run by this machine's clock, and be pulled gently to what came.
  advance(now) {
    const passed = Math.min((now - (this.last ?? now)) / 1000, 0.5);
    this.last = now;
    const goal = this.ring.end - BEHIND * this.perSecond;
    if (this.head === null || Math.abs(goal - this.head) > 0.7 * this.perSecond) this.head = goal;
    this.head += passed * this.perSecond;
    this.head += (goal - this.head) * Math.min(1, 3 * passed);
    this.head = Math.min(this.head, this.ring.end);
  }

  frame(now) {
    if (!this.ring) return;
    this.advance(now);
    const [pen, width, height] = context(this.canvas);
    pen.font = font();
    const left = Math.ceil(pen.measureText(`+0.025 ${this.unit}`).width) + 10;
    const right = width - 4;
    const start = this.head - this.shown;
    const x = (column) => left + ((column - start) / this.shown) * (right - left);
    this.fit(start);
    const lane = (height - TOP - BOTTOM) / this.fingers.length;
    // First the marks: no line may hide the beginning of what it marks.
    for (const mark of this.marks) this.mark(pen, mark, x(mark.at), left, right, height, lane);
    this.fingers.forEach((finger, k) => {
      const middle = TOP + lane * (k + 0.5);
      const scale = (0.46 * lane) / this.range;
      this.axis(pen, left, right, middle, scale);
      pen.save();
      pen.beginPath();
      pen.rect(left, TOP + lane * k, right - left, lane);
      pen.clip();
      this.stroke(pen, k, finger, x, (v) => middle - v * scale, start);
      pen.restore();
    });
    this.time(pen, left, right, height);
    this.fingers.forEach((finger, k) => this.name(pen, finger, left + 8, TOP + lane * (k + 0.12)));
  }

  // Both fingers share a scale: the larger one opens it at once, quiet closes it slowly.
  fit(start) {
    let peak = 0;
    for (let c = Math.max(0, Math.floor(start)); c < this.ring.end; c++) {
      for (let k = 0; k < this.fingers.length; k++) {
        const [low, high] = [this.ring.low(c, k), this.ring.high(c, k)];
        if (-low > peak) peak = -low;
        if (high > peak) peak = high;
      }
    }
    const wanted = niceAbove(Math.max(peak, this.least));
    if (wanted >= this.range) this.range = wanted;
    else if (peak < 0.9 * wanted) this.range = wanted;
  }

  axis(pen, left, right, middle, scale) {
    pen.lineWidth = 1;
    pen.strokeStyle = colour("line");
    pen.fillStyle = colour("soft");
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    for (const value of [this.range / 2, 0, -this.range / 2]) {
      const y = Math.round(middle - value * scale) + 0.5;
      pen.beginPath();
      pen.moveTo(left, y);
      pen.lineTo(right, y);
      pen.stroke();
      pen.fillText(`${volts(value)} ${this.unit}`, left - 7, y);
    }
  }

  stroke(pen, k, finger, x, y, start) {
    pen.strokeStyle = colour(FINGERS[finger]);
    pen.lineWidth = 1.6;
    pen.beginPath();
    let joined = false;
    const from = Math.max(0, this.ring.end - this.ring.size, Math.floor(start) - 1);
    for (let c = from; c < Math.min(this.ring.end, Math.ceil(this.head) + 1); c++) {
      const [low, high] = [this.ring.low(c, k), this.ring.high(c, k)];
      if (Number.isNaN(low)) {
        joined = false;
        continue;
      }
      const at = x(c);
      if (joined) pen.lineTo(at, y(low));
      else pen.moveTo(at, y(low));
      pen.lineTo(at, y(high));
      joined = true;
    }
    pen.stroke();
  }

  // The name keeps a rim of the card's colour: marks pass behind it.
  name(pen, finger, x, y) {
    pen.font = font(0.9375, 700);
    pen.textAlign = "left";
    pen.textBaseline = "top";
    pen.lineWidth = 6;
    pen.strokeStyle = colour("card");
    pen.strokeText(FINGER_NAMES[finger], x, y);
    pen.fillStyle = colour(FINGERS[finger]);
    pen.fillText(FINGER_NAMES[finger], x, y);
  }

  time(pen, left, right, height) {
    pen.fillStyle = colour("soft");
    pen.textBaseline = "bottom";
    const wide = pen.measureText(`${number(-this.seconds, 1)} s`).width;
    const steps = [4, 2].find((n) => apart((right - left) / n, wide)) ?? 1;
    for (let i = 0; i <= steps; i++) {
      const at = left + ((right - left) * i) / steps;
      const ago = this.seconds * (1 - i / steps);
      pen.textAlign = i === 0 ? "left" : i === steps ? "right" : "center";
      pen.fillText(i === steps ? "now" : `${number(-ago, 1)} s`, at, height - 2);
    }
  }

  mark(pen, mark, at, left, right, height, lane) {
    if (at < left || at > right) return;
    const k = Math.max(0, this.fingers.indexOf(mark.finger));
    const top = TOP + lane * k;
    pen.strokeStyle = pen.fillStyle = colour(FINGERS[mark.finger]);
    pen.lineWidth = 1;
    pen.globalAlpha = 0.45;
    pen.beginPath();
    pen.moveTo(at, TOP);
    pen.lineTo(at, height - BOTTOM);
    pen.stroke();
    pen.globalAlpha = 1;
    pen.beginPath();
    pen.moveTo(at - 7, top - 8);
    pen.lineTo(at + 7, top - 8);
    pen.lineTo(at, top + 4);
    pen.fill();
  }
}
