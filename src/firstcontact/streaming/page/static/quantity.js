// Quantities of estimates: their units, numbers in words, and the scale that shows values.

import { number } from "./dom.js";

let quantities = {};

export function learn(hello) {
  quantities = hello.quantities;
}

export const quantityOf = (estimate) => quantities[estimate?.quantity ?? "shore_a"];

// A value for people: whole, or three digits where values differ by factors.
export function figure(value, quantity) {
  if (!quantity.is_logarithmic) return number(value);
  return number(value, Math.max(0, 2 - Math.floor(Math.log10(Math.max(value, 1e-6)))));
}

// Ends and ticks that hold all values; Shore A always has its whole scale.
export function scaleOf(quantity, values) {
  if (quantity.name === "shore_a") return linear(0, 100, 20);
  if (quantity.is_logarithmic) return logarithmic(values.filter((value) => value > 0));
  const [least, most] = [Math.min(0, ...values), Math.max(1, ...values)];
  return linear(Math.floor(least), Math.ceil(most), Math.ceil((most - least) / 5));
}

function linear(low, high, step) {
  const ticks = [];
  for (let tick = low; tick <= high; tick += step) ticks.push(tick);
  return { low, high, ticks, place: (value) => (value - low) / (high - low) };
}

function logarithmic(values) {
  const decades = values.map((value) => Math.log10(value));
  const first = Math.floor(Math.min(0, ...decades)), last = Math.max(first + 1, Math.ceil(Math.max(...decades, 1)));
  const steps = last - first > 2 ? [1] : [1, 2, 5];
  const ticks = [];
  for (let decade = first; decade <= last; decade++) for (const step of steps) ticks.push(Number((step * 10 ** decade).toPrecision(1)));
  const [low, high] = [10 ** first, 10 ** last];
  const place = (value) => (Math.log10(Math.max(value, low)) - first) / (last - first);
  return { low, high, ticks: ticks.filter((tick) => tick <= high), place };
}
