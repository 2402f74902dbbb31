"use strict";
// The page of a labelling: keys become actions, the server answers with what is new.

const element = (id) => document.getElementById(id);
const plot = element("plot"), overview = element("overview"), form = element("run");
const HALVES = [0.005, 0.01, 0.02, 0.05, 0.1, 0.25, 0.5, 1, 2], AHEAD = 4;
const state = { recordings: [], marks: [], at: 0, zoom: 2, done: 0, cursor: null, adding: false, keys: 0, finished: false, waiting: null };
// Keys pressed before an undo or an addition is answered: only the answer says which onset they are for.
const later = [];
const signals = new Map(), asked = new Set();
let mostSignals = 400;  // so many are kept
const socket = new WebSocket(`ws://${location.host}/socket`);

const half = () => HALVES[state.zoom];
const key = (mark) => `${mark.number} ${mark.sample} ${half()}`;
const current = () => state.marks[state.at];
const send = (message) => { if (socket.readyState === 1) socket.send(JSON.stringify(message)); };

socket.addEventListener("message", (event) => {
  const said = JSON.parse(event.data);
  if (said.recordings) state.recordings = said.recordings;
  if (said.marks) {
    const here = current() && current().number;
    state.marks = said.marks;
    const at = said.at === undefined ? here : said.at;
    state.at = Math.max(0, state.marks.findIndex((m) => (at === undefined ? m.status === "found" : m.number === at)));
  }
  if (said.done !== undefined) state.done = said.done;
  if (said.mark) {
    const i = state.marks.findIndex((m) => m.number === said.mark.number);
    state.marks[i] = said.mark;
  }
  if (said.signal) {
    const s = said.signal;
    const name = `${s.number} ${s.asked} ${s.half}`;
    signals.set(name, s);
    asked.delete(name);  // what is forgotten below can be asked for again
    if (signals.size > mostSignals) signals.delete(signals.keys().next().value);
  }
  if (said.refused) tell(said.refused, false);
  if (said.finished) { state.finished = true; tell(`Written. ${said.finished.join("; ")}. This page can be closed.`, true); }
  draw();
  if (said.marks) {
    if (state.waiting && !said.refused) tell(state.waiting, true);
    state.waiting = null;
    while (later.length && !state.waiting) press(later.shift());
  }
});
socket.addEventListener("close", () => {
  if (!state.finished) tell("The command has ended. What was done is saved: give the same command again to go on.", false);
});

function tell(sentence, good) {
  element("said").textContent = sentence;
  element("said").className = good ? "good" : "";
}

// The piece for a mark; asked for once, those of the next few with it.
function piece(mark) {
  const name = key(mark);
  if (!signals.has(name) && !asked.has(name)) {
    asked.add(name);
    send({ ask: "signal", number: mark.number, recording: mark.recording, stretch: mark.stretch, sample: mark.sample, half: half() });
  }
  return signals.get(name);
}

function draw() {
  const mark = current();
  if (!mark) return;
  const recording = state.recordings[mark.recording], signal = piece(mark) || state.last;
  for (let i = 1; i <= AHEAD; i++) if (state.marks[state.at + i]) piece(state.marks[state.at + i]);
  if (signal) {
    const others = state.marks.filter((m) => m !== mark && m.recording === mark.recording && m.stretch === mark.stretch
      && Math.abs(m.sample - mark.sample) < 2 * half() * recording.rate);
    drawSignal(plot, signal, mark, others, recording, state.cursor);
    state.last = signal;
    state.shown = piece(mark) ? mark.number : null;
  }
  drawOverview(overview, state.marks, state.at);
  element("name").textContent = recording.name;
  element("place").textContent = `onset ${state.at + 1} of ${state.marks.length}, ${(mark.sample / recording.rate).toFixed(3)} s`;
  for (const status of ["accepted", "rejected", "found"]) element(status).textContent = count(status);
  const finger = recording.channels[mark.column].finger, [quantity, value] = levelOf(mark);
  const level = value === null ? "" : `, ${value} ${UNITS[quantity]}`;
  const moved = mark.found === null ? ", added" : mark.found === mark.sample ? ""
    : `, moved by ${(1000 * (mark.sample - mark.found) / recording.rate).toFixed(2)} ms`;
  element("what").textContent = `${mark.object || "unknown object"}${level}: ${finger}, ${mark.status === "found" ? "undecided" : mark.status}${moved}`;
  document.body.dataset.shown = `${mark.number} ${mark.status} ${mark.sample}`;
}

function go(to) {
  state.at = Math.min(Math.max(to, 0), state.marks.length - 1);
  state.cursor = null;
  state.adding = false;
  draw();
}

function act(action) {
  tell("", true);
  state.adding = false;
  send({ number: current().number, ...action });
}

// As act, for what changes more than this onset: where to go on is in the answer.
function wait(action, sentence) {
  act(action);
  state.waiting = sentence;
}

// What will be answered is shown at once.
function judge(status, action) {
  act({ do: action });
  state.marks[state.at] = { ...current(), status };
  const open = count("found");
  if (state.at === state.marks.length - 1) {
    tell(open ? `This was the last onset; ${open} before it ${open > 1 ? "are" : "is"} undecided. Tab goes there.` : "All onsets are decided. Press f to finish.", !open);
  }
  go(state.at + 1);
}

const count = (status) => state.marks.filter((m) => m.status === status).length;

// The next undecided onset; from the last one on, the first.
function nextOpen() {
  const isOpen = (m, k) => m.status === "found" && k !== state.at, after = state.marks.findIndex((m, k) => k > state.at && isOpen(m, k));
  const to = after < 0 ? state.marks.findIndex(isOpen) : after;
  if (to < 0) tell("No other onset is undecided.", true); else tell("", true);
  go(to < 0 ? state.at : to);
}

function finish() {
  const open = count("found");
  const left = open ? `${open} of ${state.marks.length} onsets ${open > 1 ? "are" : "is"} undecided and will not become ${open > 1 ? "contacts" : "a contact"}. ` : "";
  if (confirm(`${left}Write the new recordings and end?`)) send({ ask: "finish" });
}

function move(by) {
  const mark = current(), sample = Math.max(0, mark.sample + Math.round(by));
  act({ do: "move", sample });
  const signal = piece(mark);
  state.marks[state.at] = { ...mark, sample, status: "accepted" };
  // The picture stays where it is while the onset moves in it.
  if (signal) signals.set(key(current()), signal);
  draw();
}

function sampleAt(x) {
  const signal = signals.get(key(current())) || state.last, { first, perPixel } = span(signal, plot.clientWidth);
  return Math.max(0, Math.round(first + x * perPixel - 0.5));
}

// What is pointed at is this onset's signal only once that has come.
const drawn = () => signals.has(key(current()));

function add(x) {
  if (!drawn()) return;
  wait({ do: "add", sample: sampleAt(x) }, "Added.");
}

// A finger or mouse that presses the button points at no place: the next one that it touches is meant.
function addNext() {
  state.adding = true;
  tell("Touch the place of the new onset in the signal.", true);
}

const UNITS = { shore_a: "Shore A", modulus_mpa: "MPa", stiffness_n_per_mm: "N/mm" };

// Quantity and value of an onset's label; null where it is not known.
function levelOf(mark) {
  const quantity = Object.keys(UNITS).find((name) => mark[name] !== null);
  return quantity ? [quantity, mark[quantity]] : ["shore_a", null];
}

// Each object's level, as it was given last.
const levels = () => new Map(state.marks.filter((m) => m.object).map((m) => [m.object, levelOf(m)]));

function fillLevel([quantity, value] = [element("quantity").value, null]) {
  element("shore").value = value ?? "";
  if (value !== null) element("quantity").value = quantity;
  element("shore").dataset.typed = "";
}

function openForm() {
  form.hidden = false;
  element("object").value = current().object;
  fillLevel(levelOf(current()));
  element("objects").replaceChildren(...[...levels().keys()].map((name) => new Option(name)));
  element("object").focus();
  element("object").select();
}

function closeForm() {
  form.hidden = true;
  document.activeElement.blur();
}

form.addEventListener("submit", (event) => {
  event.preventDefault();
  const text = element("shore").value.trim().replace(",", "."), value = text === "" ? null : Number(text);
  const quantity = element("quantity").value, [least, most] = quantity === "shore_a" ? [0, 100] : [1e-4, 1e6];
  if (value !== null && !(value >= least && value <= most)) return tell(`${UNITS[quantity]} goes from ${least} to ${most}.`, false);
  act({ do: "label", object: element("object").value.trim(), [quantity]: value });
  closeForm();
});

// The level follows the object, until somebody types one: that of another object must not stay.
element("object").addEventListener("input", () => {
  if (!element("shore").dataset.typed) fillLevel(levels().get(element("object").value.trim()));
});
element("shore").addEventListener("input", () => { element("shore").dataset.typed = "yes"; });
element("quantity").addEventListener("keydown", (event) => { if (event.key === "Enter") { event.preventDefault(); form.requestSubmit(); } });

const rate = () => state.recordings[current().recording].rate;
const KEYS = {
  " ": () => judge("accepted", "accept"), Enter: () => judge("accepted", "accept"), a: () => judge("accepted", "accept"),
  x: () => judge("rejected", "reject"), r: () => judge("rejected", "reject"), Delete: () => judge("rejected", "reject"),
  u: () => wait({ do: "undo" }, "Undone: this onset is as it was before."), ArrowLeft: () => go(state.at - 1), ArrowRight: () => go(state.at + 1),
  Home: () => go(0), End: () => go(state.marks.length - 1),
  Tab: nextOpen,
  ",": () => move(-1), ".": () => move(1), "<": () => move(-rate() / 1000), ">": () => move(rate() / 1000),
  "+": () => zoom(-1), "=": () => zoom(-1), "-": () => zoom(1),
  o: openForm, n: () => add(state.cursor === null ? plot.clientWidth / 2 : state.cursor),
  f: finish,
};

function press(name) {
  if (state.waiting) later.push(name); else KEYS[name]();
}

function zoom(by) {
  state.zoom = Math.min(Math.max(state.zoom + by, 0), HALVES.length - 1);
  draw();
}

document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.altKey || event.metaKey) return;
  if (!form.hidden) { if (event.key === "Escape") closeForm(); return; }
  if (!current() || state.finished || !KEYS[event.key]) return;
  event.preventDefault();
  state.keys += 1;
  press(event.key);
});
for (const button of document.querySelectorAll(".keys button")) {
  button.addEventListener("mousedown", (event) => event.preventDefault());  // the keys stay with the page
  button.addEventListener("click", () => { if (form.hidden && current() && !state.finished) (button.dataset.key === "n" ? addNext() : press(button.dataset.key)); });
}
plot.addEventListener("mousemove", (event) => { state.cursor = event.offsetX; draw(); });
plot.addEventListener("mouseleave", () => { state.cursor = null; draw(); });
plot.addEventListener("click", (event) => {
  if (!current() || state.finished) return;
  if (event.shiftKey || state.adding) add(event.offsetX);
  else if (drawn()) move(sampleAt(event.offsetX) - current().sample);
});
overview.addEventListener("click", (event) => go(Math.floor((event.offsetX / overview.clientWidth) * state.marks.length)));
window.addEventListener("resize", draw);
