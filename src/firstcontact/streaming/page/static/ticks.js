// Ticks whose labels never touch: round steps, as small as the labels leave room for.

const GAP = 8;
const DECADES = [1, 10, 100, 1000, 1e4, 1e5, 1e6];
const STEPS = DECADES.flatMap((decade) => [decade, 2 * decade, 5 * decade]);

// Whether labels this wide stand apart at this distance; the outer ones may lean inwards.
export const apart = (distance, width) => distance >= 1.5 * width + GAP;

// The smallest step from `least` on for values from 0 to a full step above `last`.
export function upTo(last, least, room, widthOf) {
  for (const step of STEPS) {
    const most = step * Math.ceil(last / step);
    if (step >= least && apart((step / most) * room, widthOf(most))) return [step, most];
  }
  return [last, last];
}

// The smallest step from `least` on at a fixed scale, in pixels each.
export function within(least, scale, width) {
  return STEPS.find((step) => step >= least && apart(step * scale, width)) ?? Infinity;
}
