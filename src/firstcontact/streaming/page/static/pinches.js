// The last pinches, the newest on top.

import { FINGERS, byId, make, number } from "./dom.js";

const SHOWN = 12;
const SHORT = ["Index", "Thumb", "Sensor"];

function cell(row, className, ...inside) {
  const td = make("td", className);
  td.append(...inside);
  row.append(td);
}

function row(pinch) {
  const tr = make("tr");
  cell(tr, "", String(pinch.number));
  // The top of the page says already that it is a twin.
  cell(tr, "left object", pinch.object.replace(/^twin: /, "") || "–");
  tr.lastChild.title = pinch.object;
  if (pinch.lost) tr.lastChild.append(make("b", "lost", `✕ ${pinch.lost}`));
  if (pinch.finger === null) cell(tr, "left", "–");
  else cell(tr, `left ${FINGERS[pinch.finger]}`, make("span", "swatch"), SHORT[pinch.finger]);
  if (!pinch.estimate) {
    cell(tr, "", "–");
    cell(tr, "", "–");
  } else {
    const { value, low, high } = pinch.estimate;
    cell(tr, "", make("b", "", number(value)), make("small", "", high > low ? `${number(low)}–${number(high)}` : ""));
    cell(tr, "", pinch.ms === null ? "–" : number(pinch.ms, 1));
  }
  cell(tr, "", pinch.offset === null ? "–" : number(pinch.offset, 1));
  const late = pinch.later ? [make("small", "later", `later ${number(pinch.later.value)}, after ${number(pinch.later.ms, 1)} ms`)] : [];
  if (pinch.case === "NONE") cell(tr, "left refused", `none: ${pinch.refused || "no window"}`);
  else if (pinch.case === "TOO_LATE") cell(tr, "left late", "✕ none in time", ...late);
  else if (pinch.strange) cell(tr, "left strange", pinch.case ? "✓ but out of range" : "! out of range", ...late);
  else if (pinch.case === "IN_TIME") cell(tr, "left good", pinch.offset === null ? "✓ no 2nd heard" : "✓ in time", ...late);
  else cell(tr, "left refused", "not in real time");
  return tr;
}

// What a device that answers by itself told of the same pinch, below it.
function rows(pinch) {
  if (!pinch.hand) return [row(pinch)];
  const tr = make("tr");
  cell(tr, "left told", pinch.hand);
  tr.lastChild.colSpan = 7;
  return [row(pinch), tr];
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
