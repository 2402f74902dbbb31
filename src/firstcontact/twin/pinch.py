"""Simulation of one pinch: first the mechanics, then the electronics of the fingertips."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Finger, Label, Pinch, fingertip_layout
from firstcontact.core.layout import FINGERTIP_RATE, TAXELS
from firstcontact.twin._run import SUBSTEPS, PinchRun, whole_motions
from firstcontact.twin.draw import PinchDraw
from firstcontact.twin.drive import Positions
from firstcontact.twin.mechanics import (
    BUFFER,
    FingerParameters,
    ObjectParameters,
    Timing,
    VelostatParameters,
)
from firstcontact.twin.noise import MotorNoise
from firstcontact.twin.sensor import (
    PinchFingertips,
    piezo_readings,
    settled_filter,
    smoothed,
    strip_contacts,
)

#: Length of a pinch, s.
DURATION = 0.3
#: Number of samples before the first one, while vibration builds up.
BURN_IN = 100
#: Number of pinches that are integrated together.
_TOGETHER = 8
_LAYOUT = fingertip_layout()


def excerpt(draw: PinchDraw, lead: float) -> PinchDraw:
    """Return the parameters of a pinch, shifted to begin ``lead`` s before the first contact."""
    timing = draw.timing
    offset = timing.second - timing.first
    return replace(draw, timing=timing._replace(first=lead, second=lead + offset))


def integrate_pinch(
    draw: PinchDraw, substeps: int = SUBSTEPS, duration: float = DURATION
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Integrate a pinch. Return the times of the samples, s, and the motion at each.

    ``substeps`` is the number of integration steps per sample.
    """
    run = PinchRun(draw, duration, BURN_IN, substeps=substeps)
    out = run.advance(run.times.size)
    return _settled_times(run), out[BURN_IN:]


class PinchJob(NamedTuple):
    draw: PinchDraw
    """Drawn pinch. Its random generator advances."""
    label: Label
    """Label of the object."""
    first_sample: int = 0
    """Sample number of the first sample."""
    positions: Positions | None = None
    """Position sensor of the drives, which gives the closing speed; None without one."""


def simulate_pinch(
    draw: PinchDraw,
    label: Label,
    first_sample: int = 0,
    duration: float = DURATION,
    positions: Positions | None = None,
) -> Pinch:
    """Simulate a pinch with these drawn parameters. Return it as the device would send it.

    Parameters
    ----------
    draw, label, first_sample, positions
        Result of :func:`draw_pinch`, label of the object, number of the first sample, and position
        sensor of the drives (None for a hand without one).
    duration
        Length of the pinch, s.

    Returns
    -------
    Pinch
        int16 samples in :func:`firstcontact.core.layout.fingertip_layout`, with the true contacts
        that the simulated contact strips show.
    """
    (pinch,) = simulate_pinches([PinchJob(draw, label, first_sample, positions)], duration)
    return pinch


def simulate_pinches(jobs: Sequence[PinchJob], duration: float = DURATION) -> Iterator[Pinch]:
    """Yield the pinches of all jobs as :func:`simulate_pinch` does, but faster, in batches."""
    for start in range(0, len(jobs), _TOGETHER):
        batch = jobs[start : start + _TOGETHER]
        runs = [PinchRun(job.draw, duration, BURN_IN) for job in batch]
        for job, run, motion in zip(batch, runs, whole_motions(runs), strict=True):
            yield _pinch(job, _settled_times(run), motion[BURN_IN:])


def _pinch(job: PinchJob, times: NDArray[np.float64], motion: NDArray[np.float64]) -> Pinch:
    draw, first_sample = job.draw, job.first_sample
    scans = PinchFingertips(draw, times).read(motion)
    data = settled_filter(scans[0], draw.velostat).update(scans)
    first = Finger.INDEX if draw.timing.first_is_index else Finger.THUMB
    truth = strip_contacts(scans, first_sample)
    truth.sort(key=lambda c: (c.sample, c.finger != first))
    speed = None
    if job.positions is not None and truth:
        job.positions.add(motion, first_sample)
        speed = job.positions.speed(truth[0].sample)
    return Pinch(data, _LAYOUT, job.label, first_sample, tuple(truth), closing_speed=speed)


def _settled_times(run: PinchRun) -> NDArray[np.float64]:
    """Return the sample times of a pinch, s, without the start in which the simulation settles."""
    return run.times[BURN_IN:] - BURN_IN / FINGERTIP_RATE


def touch_voltage(
    finger: FingerParameters, target: ObjectParameters, noise: MotorNoise, jitter: float,
    lead: float, tail: float, rng: np.random.Generator,
) -> NDArray[np.float64]:  # fmt: skip
    """Return the piezo's voltage, V, around the contact of one finger.

    It begins ``lead`` s before the contact and ends ``tail`` s after it.
    """
    # The other finger never touches and so has no effect.
    timing = Timing(lead + rng.uniform(0, 1 / FINGERTIP_RATE), math.inf, True)
    sheets, shares = (VelostatParameters(),) * 2, np.full((2, TAXELS), 1 / TAXELS)
    fingers, noises = (finger, finger), (noise, noise)
    draw = PinchDraw(fingers, target, timing, noises, sheets, shares, jitter, rng)
    run = PinchRun(draw, lead + tail, BURN_IN)
    volts = run.advance(run.times.size)[:, 0, BUFFER]
    hum = 2 * math.pi * (noise.mains_rate * run.times + rng.random())
    return volts + noise.hum * np.sin(hum) + noise.electronics * rng.standard_normal(volts.size)


def piezo_samples(volts: NDArray[np.float64]) -> NDArray[np.int16]:
    """Convert a voltage from :func:`touch_voltage` into samples as a device sends them."""
    return smoothed(piezo_readings(volts))[BURN_IN:]
