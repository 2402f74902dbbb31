// The force arrays of both fingers: three rows of two, as on the finger.

import { FINGERS, FINGER_NAMES, byId, make, number, setText } from "./dom.js";

const FULL_VOLTS = 3.3;

export class Force {
  hello(hello) {
    this.unit = hello.force_unit;
    this.full = FULL_VOLTS;
    const root = byId("force");
    root.replaceChildren();
    this.cells = {};
    if (hello.force_fingers.length === 0) root.append(make("p", "soft", "This sensor has no force array."));
    for (const finger of hello.force_fingers) {
      const map = make("div", `map ${FINGERS[finger]}`);
      map.append(make("h3", "", FINGER_NAMES[finger]));
      const grid = make("div", "taxels");
      this.cells[finger] = Array.from({ length: 6 }, () => {
        const cell = make("div", "taxel");
        const [fill, text] = [make("i"), make("b", "", "–")];
        cell.append(fill, text);
        grid.append(cell);
        return [fill, text];
      });
      map.append(grid);
      root.append(map);
    }
    this.note();
  }

  // Volts fill up to the supply; newtons to the most that was seen.
  note() {
    if (!this.unit) return;
    setText(byId("force-note"), `${this.unit}, darkest at ${number(this.full, 1)}`);
  }

  force(force) {
    for (const [finger, values] of Object.entries(force)) {
      values.forEach((value, k) => {
        const cell = this.cells[finger]?.[k];
        if (!cell) return;
        if (this.unit !== "V" && value > this.full) {
          this.full = value;
          this.note();
        }
        const share = Math.min(1, Math.max(0, value / this.full));
        cell[0].style.opacity = (0.75 * Math.sqrt(share)).toFixed(2);
        setText(cell[1], number(value, 2));
      });
    }
  }
}
