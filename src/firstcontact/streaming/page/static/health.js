// How the link is doing, and the times so far.

import { byId, make, number, setText } from "./dom.js";

const FACTS = [
  ["samples", "Samples received", false],
  ["lost_samples", "Samples lost", true],
  ["overflow_samples", "– of these, lost in the device", true],
  ["lost_frames", "Frames lost", true],
  ["bad_frames", "Frames damaged", true],
  ["doubled_frames", "Frames received twice", true],
  ["reconnects", "Reconnects", true],
];
const STAGES = { decide: "detection", first: "first estimate", total: "final estimate", signal: "– of it, signal used", wait: "– of it, waiting", transport: "– of it, transfer", compute: "– of it, computation" };
const COUNTS = { pinches: "Pinches", in_time: "– in time", hand_used: "– used by the hand", too_late: "– too late", none: "– without estimate", unjudged: "– time not known", overruns: "Blocks processed too slowly" };
const STATISTICS = ["p50", "p99", "max"];

function facts(root, list) {
  if (root.children.length !== 2 * list.length) {
    root.replaceChildren(...list.flatMap(() => [make("dt"), make("dd")]));
  }
  list.forEach(([name, value, bad], i) => {
    const [dt, dd] = [root.children[2 * i], root.children[2 * i + 1]];
    setText(dt, name);
    setText(dd, value);
    dt.className = dd.className = bad ? "bad" : "";
  });
}

export class Health {
  hello(hello) {
    this.rate = hello.rate;
    this.viewing = { viewers: 1, skipped: 0 };
    this.state = null;
    this.blank();
  }

  blank() {
    byId("counts").replaceChildren();
  }

  viewer(viewer) {
    this.viewing = viewer;
    this.paint();
  }

  health(health) {
    this.state = health;
    this.paint();
  }

  columnSeconds(hello) {
    this.perColumn = hello.column_samples / hello.rate;
  }

  paint() {
    const h = this.state;
    if (!h) return;
    const list = FACTS.map(([key, name, loss]) => [name, number(h[key]), loss && h[key] > 0]);
    const off = 1e6 * (h.host_rate / this.rate - 1);
    const known = h.host_rate > 0;
    list.push(["Sampling rate", known ? `${number(h.host_rate, 1)} Hz` : "–", false]);
    list.push([`– deviation from ${number(this.rate)} Hz`, known ? `${off > 0 ? "+" : ""}${number(off)} ppm` : "–", false]);
    const skipped = this.viewing.skipped * (this.perColumn ?? 0);
    list.push(["Skipped by this page", `${number(skipped, 1)} s`, skipped > 0]);
    list.push(["Viewers", number(this.viewing.viewers), false]);
    facts(byId("health"), list);
  }

  ledger(figures) {
    const stages = new Map();
    const counts = [];
    for (const [key, value] of Object.entries(figures)) {
      const [, stage, statistic] = key.match(/^(.*)_(p50|p99|max)$/) ?? [];
      if (statistic) stages.set(stage, { ...stages.get(stage), [statistic]: value });
      else if (COUNTS[key]) counts.push([COUNTS[key], number(value), key === "overruns" && value > 0]);
    }
    if (stages.size === 0) return;
    // In the order in which they happen; what is not known by name comes last.
    const names = [...new Set([...Object.keys(STAGES), ...stages.keys()])].filter((s) => stages.has(s));
    const rows = names.map((stage) => {
      const values = stages.get(stage);
      const tr = make("tr");
      tr.append(make("td", "left", STAGES[stage] ?? stage));
      for (const name of STATISTICS) tr.append(make("td", "", name in values ? number(1e3 * values[name], 2) : "–"));
      return tr;
    });
    byId("ledger").replaceChildren(...rows);
    facts(byId("counts"), counts);
  }
}

// One word for the link, for the top of the page.
export function verdict(health) {
  if (!health.connected) return ["bad", "! Not connected"];
  if (health.lost_samples > 0) return ["bad", `! ${number(health.lost_samples)} samples lost`];
  if (health.lost_frames > 0) return ["bad", `! ${number(health.lost_frames)} frames lost`];
  return ["good", "✓ Nothing lost"];
}
