// The samples around the last first contact, with the signal that the estimate is from.

import { FINGERS, byId, colour, context, font, niceAbove, setText, volts, watch } from "./dom.js";
import { shown } from "./events.js";
import { within } from "./ticks.js";

const TOP = 16;
const BOTTOM = 26;

export class Closeup {
  constructor(canvas) {
    this.canvas = canvas;
    this.tree = null;
    this.window = 15;
    watch(canvas, () => this.paint());
  }

  hello(hello) {
    this.fingers = hello.fingers;
    this.unit = hello.unit;
    this.tree = null;
  }

  closeup(tree) {
    this.tree = tree;
    this.paint();
  }

  now(now) {
    const estimate = shown(now);
    if (estimate && 1000 * estimate.elapsed !== this.window) {
      this.window = 1000 * estimate.elapsed;
      setText(byId("window-note"), `shaded: the ${Math.round(10 * this.window) / 10} ms used for the estimate`);
      this.paint();
    }
  }

  paint() {
    const [pen, width, height] = context(this.canvas);
    pen.font = font();
    if (!this.tree) {
      pen.fillStyle = colour("soft");
      pen.textAlign = "center";
      pen.fillText("No contact yet.", width / 2, height / 2);
      return;
    }
    const { ms, traces, marks } = this.tree;
    const left = Math.ceil(pen.measureText(`+0.5 ${this.unit}`).width) + 10;
    const right = width - 6;
    const [from, to] = [ms[0], ms[ms.length - 1]];
    const x = (t) => left + ((t - from) / (to - from)) * (right - left);
    let peak = 0.02;
    for (const trace of traces) for (const v of trace) if (Math.abs(v) > peak) peak = Math.abs(v);
    const range = niceAbove(peak);
    const middle = (TOP + height - BOTTOM) / 2;
    const y = (v) => middle - (v / range) * ((height - TOP - BOTTOM) / 2);

    pen.fillStyle = colour("window");
    pen.fillRect(x(0), TOP, x(this.window) - x(0), height - TOP - BOTTOM);
    pen.strokeStyle = colour("line");
    pen.fillStyle = colour("soft");
    pen.lineWidth = 1;
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    for (const v of [range, 0, -range]) {
      pen.beginPath();
      pen.moveTo(left, Math.round(y(v)) + 0.5);
      pen.lineTo(right, Math.round(y(v)) + 0.5);
      pen.stroke();
      pen.fillText(`${volts(v)} ${this.unit}`, left - 7, y(v));
    }
    pen.textBaseline = "bottom";
    const wide = pen.measureText("30 ms").width;
    for (let t = 0; t <= to; t += within(10, x(1) - x(0), wide)) {
      pen.textAlign = x(t) > right - wide / 2 ? "right" : "center";
      pen.fillText(t === 0 ? "0" : `${t} ms`, x(t), height - 2);
    }
    traces.forEach((trace, k) => this.line(pen, trace, ms, this.fingers[k], x, y));
    for (const mark of marks) this.mark(pen, mark, x(mark.ms), height);
  }

  line(pen, trace, ms, finger, x, y) {
    pen.strokeStyle = colour(FINGERS[finger]);
    pen.lineWidth = 2;
    pen.beginPath();
    let joined = false;
    trace.forEach((v, i) => {
      if (v === null) joined = false;
      else if (joined) pen.lineTo(x(ms[i]), y(v));
      else {
        pen.moveTo(x(ms[i]), y(v));
        joined = true;
      }
    });
    pen.stroke();
  }

  mark(pen, mark, at, height) {
    pen.strokeStyle = pen.fillStyle = colour(FINGERS[mark.finger]);
    pen.lineWidth = 2;
    pen.beginPath();
    pen.moveTo(at, TOP);
    pen.lineTo(at, height - BOTTOM);
    pen.stroke();
    pen.beginPath();
    pen.moveTo(at - 7, TOP - 10);
    pen.lineTo(at + 7, TOP - 10);
    pen.lineTo(at, TOP + 2);
    pen.fill();
  }
}
