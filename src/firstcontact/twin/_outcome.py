"""What became of a pinch, read off its forces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import FINGERTIP_RATE, GRAVITY
from firstcontact.twin._compiled import compiled

#: A stable grasp presses with so many times the force that just holds the object.
SAFETY = 1.25
#: And its force, smoothed over this time, s,
SMOOTHED = 0.010
#: changes by no more than this, N/s.
STEADY = 15.0
#: An object that has slipped so far is dropped, m.
DROPPED = 0.010


@dataclass(frozen=True, slots=True)
class GraspOutcome:
    """How a pinch went; of an object that broke, up to then.

    Parameters
    ----------
    peak_force
        Largest grip force, N; the grip force is the smaller one of both contacts'.
    squeeze
        Most that the object was pressed together: its bulk and its share of both
        indentations, m.
    time_to_grasp
        From the first contact to the instant from which on the grip is strong enough
        and steady, s; None if there is none, or if the object broke.
    slipped
        How far the object slid down, m.
    dropped
        It slipped out, or is about to.
    broken
        A contact force was more than it bears.
    first_contact, second_contact
        When fingers touched, s from the first sample; None if they did not.
    """

    peak_force: float
    squeeze: float
    time_to_grasp: float | None
    slipped: float
    dropped: bool
    broken: bool
    first_contact: float | None
    second_contact: float | None

    @property
    def held(self) -> bool:
        """Both fingers have it, and it is neither dropped nor broken."""
        return self.second_contact is not None and not (self.dropped or self.broken)


@compiled()
def slide(
    forces: NDArray[np.float64],
    hanging: NDArray[np.float64],
    mass: float,
    friction: float,
    dt: float,
    slid: NDArray[np.float64],
    out: NDArray[np.float64],
) -> None:
    """Let the support go and let friction do what it can, for the next samples.

    Parameters
    ----------
    forces
        Both contact forces, N, shape (samples, 2).
    hanging
        Share of the weight that no support carries, shape (samples,).
    mass, friction
        The object's, kg, and against either finger.
    dt
        Sampling interval, s.
    slid
        How far it slid before (m) and how fast (m/s), shape (2,).
    out
        The same after each sample, shape (samples, 2).
    """
    way, speed = slid[0], slid[1]
    for i in range(len(forces)):
        held = friction * (forces[i, 0] + forces[i, 1]) / mass
        pull = GRAVITY * hanging[i]
        if speed > 0.0 or held < pull:
            change = (pull - held) * dt
            new = max(speed + change, 0.0)
            way += 0.5 * (speed + new) * dt
            speed = new
        out[i, 0], out[i, 1] = way, speed


def stable_from(grip: NDArray[np.float64], needed: float) -> int | None:
    """Sample from which on a grip force (N, shape (samples,)) is strong enough and steady."""
    width = round(SMOOTHED * FINGERTIP_RATE)
    if len(grip) < 3 * width:
        return None
    smooth = np.convolve(grip, np.full(width, 1 / width), "valid")
    rate = np.abs(smooth[width:] - smooth[:-width]) / (width / FINGERTIP_RATE)
    weak = smooth[width:] < SAFETY * needed
    bad = np.flatnonzero(weak | (rate > STEADY))
    # Row i knows the samples from i to i + 2 width.
    first = int(bad[-1]) + 1 if bad.size else 0
    return None if first >= len(rate) else first + 2 * width - 1
