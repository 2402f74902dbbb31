"""One pinch of the twin: the mechanics, then the fingertips."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import FINGERTIP_RATE, Finger, Label, Pinch, fingertip_layout
from firstcontact.twin._draw import PinchDraw
from firstcontact.twin._filter import settled_filter
from firstcontact.twin._fingertips import PinchFingertips, strip_contacts
from firstcontact.twin._positions import Positions
from firstcontact.twin._run import SUBSTEPS, PinchRun, whole_motions

#: Length of a pinch, s.
DURATION = 0.3
#: Number of samples before the first one in which vibration builds up.
BURN_IN = 100
#: Number of pinches that are integrated together.
_TOGETHER = 8
_LAYOUT = fingertip_layout()


def excerpt(draw: PinchDraw, lead: float) -> PinchDraw:
    """Return the drawn pinch, changed to begin ``lead`` s before the first contact.

    Use it with a short duration if you need only the time around the contact: simulating 60 ms
    takes a quarter of the time of a whole pinch. A part of the free closing is left out. The
    vibration still has :data:`BURN_IN` samples to build up.
    """
    timing = draw.timing
    offset = timing.second - timing.first
    return replace(draw, timing=timing._replace(first=lead, second=lead + offset))


def integrate_pinch(
    draw: PinchDraw, substeps: int = SUBSTEPS, duration: float = DURATION
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the sampling instants and the motion of a drawn pinch.

    Returns
    -------
    tuple
        Sampling instants (s, the first contact at ``draw.timing.first``), shape (samples,), and
        Output of a :class:`firstcontact.twin._mechanics.Piece`, shape (samples, 2, 5).
    """
    run = PinchRun(draw, duration, BURN_IN, substeps=substeps)
    out = run.advance(run.times.size)
    return _times(run), out[BURN_IN:]


def pinch_scans(draw: PinchDraw, duration: float = DURATION) -> NDArray[np.uint16]:
    """Return the raw scans of one pinch, shape (samples, 6), in the order of ``SCAN``."""
    times, motion = integrate_pinch(draw, duration=duration)
    return PinchFingertips(draw, times).read(motion)


class PinchJob(NamedTuple):
    """Drawn pinch to simulate."""

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
    """Return a drawn pinch with the samples that the device sends for it.

    Parameters
    ----------
    draw, label, first_sample, positions
        See :class:`PinchJob`.
    duration
        Length of the pinch, s.

    Returns
    -------
    Pinch
        int16 samples in :func:`firstcontact.core._layout.fingertip_layout`. Its true contacts come
        from the strips.
    """
    (pinch,) = simulate_pinches([PinchJob(draw, label, first_sample, positions)], duration)
    return pinch


def simulate_pinches(jobs: Sequence[PinchJob], duration: float = DURATION) -> Iterator[Pinch]:
    """Yield drawn pinches like :func:`simulate_pinch`, faster: several are integrated together.

    Parameters
    ----------
    jobs
        Drawn pinches.
    duration
        Length of each pinch, s.
    """
    for start in range(0, len(jobs), _TOGETHER):
        batch = jobs[start : start + _TOGETHER]
        runs = [PinchRun(job.draw, duration, BURN_IN) for job in batch]
        for job, run, motion in zip(batch, runs, whole_motions(runs), strict=True):
            yield _pinch(job, _times(run), motion[BURN_IN:])


def _pinch(job: PinchJob, times: NDArray[np.float64], motion: NDArray[np.float64]) -> Pinch:
    """Return the pinch of a simulated motion."""
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


def _times(run: PinchRun) -> NDArray[np.float64]:
    """Return the sampling instants after the burn-in, s."""
    return run.times[BURN_IN:] - BURN_IN / FINGERTIP_RATE
