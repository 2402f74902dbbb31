// Puts the page together: each message goes to the parts that show it.

import { byId, readColours, setText } from "./dom.js";
import { Closeup } from "./closeup.js";
import { Controls } from "./controls.js";
import { Estimate } from "./estimate.js";
import { Force } from "./force.js";
import { Hand } from "./hand.js";
import { Health, verdict } from "./health.js";
import { Link } from "./link.js";
import { pinches } from "./pinches.js";
import { Timing } from "./timing.js";
import { Traces } from "./traces.js";

// The token became a cookie: it need not stand in the address, where others may read it.
if (location.search) history.replaceState(null, "", location.pathname);

// Nothing for this long is worth a word, s.
const SILENCE = 1.5;
const BADGES = { twin: "Twin (simulated)", synthetic: "Synthetic", real: "Real hand" };

readColours();
const traces = new Traces(byId("traces"));
const closeup = new Closeup(byId("closeup"));
const estimate = new Estimate();
const timing = new Timing();
const force = new Force();
const health = new Health();
let link = null;
const controls = new Controls(() => link, () => estimate.object(null));
const hand = new Hand((what) => controls.ask(what), () => link?.ask({ do: "here" }));
const parts = [traces, closeup, estimate, timing, force, health, controls, hand];
const state = { there: false, health: null, gone: false, faults: [], failed: null, delay: "" };

function hello(tree) {
  state.there = true;
  state.gone = false;
  state.faults = [];
  state.failed = null;
  state.delay = "";
  health.columnSeconds(tree);
  for (const part of parts) part.hello(tree);
  pinches([]);
  const badge = byId("source");
  setText(badge, BADGES[tree.source] ?? tree.source);
  badge.classList.toggle("plain", tree.source === "real");
  badge.hidden = false;
  setText(byId("about"), [tree.sensor, tree.hand, tree.firmware].filter(Boolean).join(" · "));
}

// What this page itself does wrong, once: it goes on with the rest.
function failed(what, error) {
  state.failed = `this page cannot show ${what} (${error.message}), reload it`;
}

function lost() {
  state.gone = true;
  controls.lost();
  hand.lost();
}

link = new Link({
  hello,
  lost,
  failed,
  faults: (faults) => { state.faults = faults; },
  columns: (first, n, _channels, values) => traces.columns(first, n, values),
  marks: (marks) => { traces.marks = marks; },
  closeup: (tree) => closeup.closeup(tree),
  now: (now) => { estimate.now(now); timing.now(now); closeup.now(now); state.delay = now.pinch ? now.pinch.delay_cause : state.delay; },
  force: (tree) => force.force(tree),
  health: (tree) => { state.health = tree; health.health(tree); },
  hand: (command) => hand.command(command),
  on_hand: (pinch) => timing.hand(pinch),
  recording: (status) => controls.recording(status),
  ledger: (figures) => health.ledger(figures),
  pinches,
  viewer: (viewer) => health.viewer(viewer),
  answer: (answer) => controls.answer(answer),
});

// What a person must know first, in one sentence; null when all is well.
function trouble(now) {
  if (state.gone) {
    return state.there
      ? "! The server is gone. What is shown is the last that came; the page tries again by itself."
      : "! No server here yet. The page tries again by itself.";
  }
  if (!state.health) return null;
  if (!state.health.connected) return "! The device is not connected: check its cable.";
  const faults = [...state.faults, state.failed].filter(Boolean);
  if (faults.length > 0) return `! ${faults.join(" · ")}.`;
  if (state.delay) return `! Estimates come too late: ${state.delay}.`;
  const silent = traces.silent(now);
  if (silent !== null && silent > SILENCE) return `! No samples for ${Math.floor(silent)} s.`;
  return null;
}

function top(now) {
  const text = trouble(now);
  byId("notice").hidden = text === null;
  if (text) setText(byId("notice"), text);
  let [kind, word] = ["wait", "Connecting"];
  if (state.gone) [kind, word] = ["bad", "! Server gone"];
  else if (state.faults.length > 0 || state.failed) [kind, word] = ["bad", "! Something failed"];
  else if (state.health) [kind, word] = verdict(state.health);
  byId("link").className = `pill ${kind}`;
  setText(byId("link"), word);
}

function frame(now) {
  requestAnimationFrame(frame);
  try {
    if (!state.gone) traces.frame(now);
  } catch (error) {
    failed("the signals", error);
  }
  top(now);
}
requestAnimationFrame(frame);

matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
  readColours();
  closeup.paint();
});
