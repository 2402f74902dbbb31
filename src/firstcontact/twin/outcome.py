"""Lift of a pinched object in simulation, and its outcome: held, dropped or broken."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from firstcontact.core.installation import load_compiled
from firstcontact.core.layout import FINGERTIP_RATE

#: Default time from the first contact to the beginning of the lift, s.
LIFT = 0.45


@dataclass(frozen=True, slots=True)
class Lift:
    """Lift of an object: the support bears less and less of the weight, linearly down to 0."""

    #: Time from the first contact to the beginning of the lift, s.
    delay: float = LIFT
    #: Duration of the lift, s; 0 for an abrupt one.
    duration: float = 0.0

    def __post_init__(self) -> None:
        if not (0 <= self.delay < math.inf and 0 <= self.duration < math.inf):
            raise ValueError(f"a time of {self} is negative: use 0 s or more")

    @property
    def begin(self) -> int:
        """Number of samples from the first contact to the start of the lift."""
        return round(self.delay * FINGERTIP_RATE)

    @property
    def samples(self) -> int:
        """Number of samples from the first contact to the end of the lift."""
        return round((self.delay + self.duration) * FINGERTIP_RATE)

    def hanging(self, first: int, samples: int) -> NDArray[np.float64]:
        """Return the share of the weight that hangs on the hand, in each of ``samples`` samples.

        ``first`` is the number of the first sample, counted from the first contact.
        """
        since = np.arange(first, first + samples) - self.begin
        ramp = self.samples - self.begin
        if ramp == 0:
            return (since >= 0).astype(np.float64)
        return np.clip(since / ramp, 0.0, 1.0)


#: Grip force of a stable grasp, relative to the least holding force, weight / (2 × friction):
#: people add 10 to 40 % [7].
SAFETY = 1.25
#: Time over which the grip force is smoothed before its rate of change is computed, s.
SMOOTHED = 0.010
#: Largest rate of change of the smoothed grip force in a stable grasp, N/s.
STEADY = 15.0
#: Distance of slip from which an object counts as dropped, m.
DROPPED = 0.010
#: Function that simulates the slip of the object under friction: of contact forces, shares of the
#: weight that hang, mass, friction, time step, last distance and speed, and an array for the next.
slide = load_compiled("firstcontact.twin._compiled").slide


@dataclass(frozen=True, slots=True)
class GraspOutcome:
    """Outcome of a simulated pinch. If the object broke, it covers only the time before."""

    #: Largest grip force, N. The grip force is the smaller contact force.
    peak_force: float
    #: Largest compression of the object, m, with its share of the indentation at both contacts.
    squeeze: float
    #: Time from the first contact until the grip is strong enough and steady to the end, s.
    time_to_grasp: float | None
    #: Distance that the object slid down, m.
    slipped: float
    #: True if the object slipped out, or is about to slip out.
    dropped: bool
    broken: bool
    #: Contact times, s from the first sample; None without contact.
    first_contact: float | None
    second_contact: float | None


def stable_since(grip: NDArray[np.float64], needed: float) -> int | None:
    """Return the sample from which on a grip force is steady and above ``needed``, N, or None."""
    width = round(SMOOTHED * FINGERTIP_RATE)
    if len(grip) < 3 * width:
        return None
    smooth = np.convolve(grip, np.full(width, 1 / width), "valid")
    rate = np.abs(smooth[width:] - smooth[:-width]) / (width / FINGERTIP_RATE)
    weak = smooth[width:] < SAFETY * needed
    bad = np.flatnonzero(weak | (rate > STEADY))
    # Element i of `rate` and `weak` uses the samples from i to i + 2 width.
    first = int(bad[-1]) + 1 if bad.size else 0
    return None if first >= len(rate) else first + 2 * width - 1
