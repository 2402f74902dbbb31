"use strict";
// Draws a piece of signal: one lane a channel, the onset, its neighbours, time from the onset.

const COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7"];
const STATUS = { found: "#8f9aa5", accepted: "#00805e", rejected: "#b3261e" };

function sharp(canvas) {
  const scale = window.devicePixelRatio || 1, width = canvas.clientWidth, height = Number(canvas.dataset.height);
  if (canvas.width !== Math.round(width * scale)) {
    canvas.width = Math.round(width * scale);
    canvas.height = Math.round(height * scale);
    canvas.style.height = `${height}px`;
  }
  const pen = canvas.getContext("2d");
  pen.setTransform(scale, 0, 0, scale, 0, 0);
  pen.clearRect(0, 0, width, height);
  return { pen, width, height };
}

// From sample to pixel: the onset's own place when it was asked for stays in the middle.
function span(signal, width) {
  const samples = signal.least[0].length * signal.step;
  return { first: signal.first, perPixel: samples / width };
}

function drawSignal(canvas, signal, mark, others, recording, cursor) {
  canvas.dataset.height = canvas.clientWidth < 500 ? 260 : 420;
  const { pen, width, height } = sharp(canvas), lanes = signal.least.length, foot = 24;
  const lane = (height - foot) / lanes, { first, perPixel } = span(signal, width);
  const x = (sample) => (sample - first + 0.5) / perPixel;
  pen.font = "12px system-ui, sans-serif";
  const milli = recording.rate / 1000, reach = (perPixel * width) / milli;
  const tick = [0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500].find((t) => reach / t <= Math.min(12, width / 70)) || 1000;
  pen.strokeStyle = "#eef1f4"; pen.fillStyle = "#52606d"; pen.textAlign = "center";
  let right = 0;
  for (let t = Math.ceil((first - mark.sample) / milli / tick) * tick; t <= (first - mark.sample) / milli + reach; t += tick) {
    const at = x(mark.sample + t * milli);
    pen.beginPath(); pen.moveTo(at, 0); pen.lineTo(at, height - foot); pen.stroke();
    const said = `${t > 0 ? "+" : t < 0 ? "−" : ""}${Math.abs(t)} ms`, room = pen.measureText(said).width / 2 + 4;
    const middle = Math.min(Math.max(at, room), width - room);
    // At the edges words are moved inwards, onto the next ones where the picture is narrow.
    if (middle - room < right) continue;
    pen.fillText(said, middle, height - 8);
    right = middle + room;
  }
  for (let k = 0; k < lanes; k++) {
    const least = signal.least[k], most = signal.most[k], low = Math.min(...least), high = Math.max(...most);
    const size = high > low ? (lane - 26) / (high - low) : 0, y = (v) => lane * (k + 1) - 8 - (v - low) * size;
    const marked = size ? values(low, high, lane) : [];
    pen.lineWidth = 1; pen.strokeStyle = "#eef1f4";
    for (const { value } of marked) { pen.beginPath(); pen.moveTo(0, y(value)); pen.lineTo(width, y(value)); pen.stroke(); }
    pen.strokeStyle = COLOURS[k % COLOURS.length]; pen.lineWidth = k === mark.column ? 1.6 : 1;
    pen.beginPath();
    least.forEach((v, i) => {
      const at = x(signal.first + i * signal.step);
      if (i) pen.lineTo(at, y(v)); else pen.moveTo(at, y(v));
      if (most[i] !== v) pen.lineTo(at, y(most[i]));
    });
    pen.stroke();
    pen.fillStyle = COLOURS[k % COLOURS.length]; pen.textAlign = "left";
    const channel = recording.channels[k];
    pen.fillText(`${channel.name}${channel.unit ? `, ${channel.unit}` : ""}`, 8, lane * k + 15);
    // At the right, since what matters is in the middle; with a rim, since the signal goes through.
    pen.lineWidth = 4; pen.strokeStyle = "#fff"; pen.fillStyle = "#52606d"; pen.textAlign = "right";
    for (const { value, text } of marked) { pen.strokeText(text, width - 6, y(value) + 4); pen.fillText(text, width - 6, y(value) + 4); }
  }
  pen.lineWidth = 1;
  for (const other of others) line(pen, x(other.sample), other, lane, height - foot, [3, 4]);
  pen.lineWidth = 2;
  line(pen, x(mark.sample), mark, lane, height - foot, []);
  if (mark.found !== null && mark.found !== mark.sample) {
    pen.lineWidth = 1;
    line(pen, x(mark.found), { ...mark, status: "found" }, lane, height - foot, [2, 3]);
  }
  if (cursor !== null) {
    pen.strokeStyle = "#1f293355"; pen.lineWidth = 1; pen.setLineDash([]);
    pen.beginPath(); pen.moveTo(cursor, 0); pen.lineTo(cursor, height - foot); pen.stroke();
  }
}

// Round values of a lane, some 45 pixels apart or more.
function values(low, high, lane) {
  const rough = (high - low) / Math.max(2, lane / 45), decade = 10 ** Math.floor(Math.log10(rough));
  const step = decade * [1, 2, 5, 10].find((m) => m * decade >= rough), digits = Math.max(0, -Math.floor(Math.log10(step)));
  const out = [];
  for (let n = Math.ceil(low / step); n * step <= high; n++) {
    const size = Math.abs(n * step), short = digits <= 4 && size < 1e5 ? size.toFixed(digits) : size.toExponential(1);
    out.push({ value: n * step, text: n ? `${n < 0 ? "−" : ""}${short}` : "0" });
  }
  return out;
}

function line(pen, at, mark, lane, bottom, dash) {
  pen.strokeStyle = STATUS[mark.status]; pen.setLineDash(dash);
  pen.beginPath(); pen.moveTo(at, 0); pen.lineTo(at, bottom); pen.stroke();
  pen.setLineDash([]);
  pen.fillStyle = STATUS[mark.status];
  pen.beginPath(); pen.arc(at, lane * mark.column + 24, 4, 0, 7); pen.fill();
}

// All onsets side by side, and where we are among them.
function drawOverview(canvas, marks, current) {
  canvas.dataset.height = 36;
  const { pen, width, height } = sharp(canvas), each = width / marks.length;
  marks.forEach((mark, i) => {
    pen.fillStyle = STATUS[mark.status];
    pen.fillRect(i * each, 10, Math.max(each - (each > 3 ? 1 : 0), 0.6), height - 14);
  });
  pen.fillStyle = "#1f2933";
  const at = (current + 0.5) * each;
  pen.beginPath(); pen.moveTo(at - 6, 0); pen.lineTo(at + 6, 0); pen.lineTo(at, 9); pen.fill();
}
