// The last pinches, the newest on top: each with the estimate in force at the second contact.

import { FINGERS, byId, make, number } from "./dom.js";
import { inForce, later } from "./events.js";
import { figure, quantityOf } from "./quantity.js";

const SHOWN = 12;
const SHORT = ["Index", "Thumb", "Sensor"];

function cell(row, className, ...inside) {
  const td = make("td", className);
  td.append(...inside);
  row.append(td);
}

function row({ pinch, name, lost }) {
  const tr = make("tr");
  const [first] = pinch.contacts;
  const estimate = inForce(pinch);
  cell(tr, "", String(pinch.number));
  // The top of the page says already that it is a twin.
  cell(tr, "left object", name.replace(/^twin: /, "") || "–");
  tr.lastChild.title = name;
  if (lost) tr.lastChild.append(make("b", "lost", `✕ ${lost}`));
  if (!first) cell(tr, "left wide", "–");
  else cell(tr, `left wide ${FINGERS[first.finger ?? 2]}`, make("span", "swatch"), SHORT[first.finger ?? 2]);
  if (!estimate) {
    cell(tr, "", "–");
    cell(tr, "wide", "–");
  } else {
    const { value, low, high } = estimate, quantity = quantityOf(estimate);
    const say = (part) => figure(part, quantity);
    cell(tr, "", make("b", "", say(value)), make("small", "", high > low ? `${say(low)}–${say(high)}` : ""));
    cell(tr, "wide", pinch.real_time ? number(1000 * estimate.available, 1) : "–");
  }
  cell(tr, "wide", pinch.offset === null ? "–" : number(1000 * pinch.offset, 1));
  if (pinch.closing_speed) tr.title = `closed at ${number(1000 * pinch.closing_speed.speed)} mm/s`;
  cell(tr, ...outcome(pinch, estimate));
  return tr;
}

// Look and words of the last column.
function outcome(pinch, estimate) {
  const late = later(pinch);
  const before = pinch.verdict === "in_time" ? "later " : "";
  const detail = late ? [make("small", "later", `${before}${figure(late.value, quantityOf(late))} after ${number(1000 * late.available, 1)} ms`)] : [];
  if (pinch.verdict === "none") return ["left refused", `no estimate: ${pinch.reason || "no model"}`];
  if (pinch.verdict === "too_late") return ["left late", "✕ too late", ...detail];
  if (estimate.out_of_range) return ["left strange", pinch.verdict ? "✓ but out of range" : "! out of range", ...detail];
  const use = pinch.hand_used === null ? "" : pinch.hand_used ? ", used by the hand" : ", not used by the hand";
  if (pinch.verdict === "in_time") return ["left good", `${pinch.offset === null ? "✓ no 2nd contact" : "✓ in time"}${use}`, ...detail];
  return ["left refused", "not in real time"];
}

// A row, and below it the predictions of a device for the same pinch.
function rows(entry) {
  if (!entry.hand) return [row(entry)];
  const tr = make("tr");
  cell(tr, "left told", entry.hand);
  tr.lastChild.colSpan = 7;
  return [row(entry), tr];
}

export function pinches(list) {
  const shown = list.slice(-SHOWN).reverse().flatMap(rows);
  if (shown.length === 0) {
    const none = make("tr");
    cell(none, "none", "No pinch yet.");
    none.lastChild.colSpan = 7;
    shown.push(none);
  }
  byId("rows").replaceChildren(...shown);
}
