// Helpers to read events, which come as the JSON of the program's own structs; times are in s.

// The last estimate of a finished pinch that was available before the second contact.
export function inForce(pinch) {
  return (pinch.real_time ? pinch.estimates.findLast((e) => e.in_time) : pinch.estimates.at(-1)) ?? null;
}

// The final estimate of a finished pinch, if it came after the one in force.
export function later(pinch) {
  const final = pinch.estimates.at(-1) ?? null;
  return final === inForce(pinch) ? null : final;
}

// The estimate that is shown large: the newest while a pinch lasts, then the one in force.
export function shown(now) {
  if (!now.pinch) return now.estimates.at(-1) ?? null;
  return inForce(now.pinch) ?? now.pinch.estimates.at(-1) ?? null;
}

// Where the time from the contact to an estimate went, ms.
export function parts(estimate) {
  const ms = (seconds) => 1000 * seconds;
  const [total, transport, compute] = [ms(estimate.available), ms(estimate.transport), ms(estimate.compute)];
  const window = Math.min(ms(estimate.elapsed), total - transport - compute);
  return { window, wait: total - transport - compute - window, transport, compute, total };
}
