"""Random batches of simulated contacts, to train the network that estimates Shore A."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from firstcontact.chain.touch import touch_inputs
from firstcontact.core.layout import FINGERTIP_RATE
from firstcontact.core.physics import MOST
from firstcontact.models import Touches
from firstcontact.models.rig.rigs import Rig
from firstcontact.signal import samples_in
from firstcontact.signal.windowing import BASELINE, BASELINE_GUARD
from firstcontact_lab.pretraining.examples import CONTEXTS, MARGIN, Examples, facts, placing, volts
from firstcontact_lab.rigs import Rng

#: Shares of contacts without a known rig, with a rig that measures closing speeds, and of these
#: without a speed; and share of round objects with a given radius. A flat object is always given as
#: flat, so one without a shape is round.
NO_CONTEXT, TOLD_SPEED, NO_SPEED, TOLD_RADIUS = 0.08, 0.25, 0.25, 0.3
_RATE = FINGERTIP_RATE
#: Smallest number of samples before a contact that the chain takes.
_LEAST_BEFORE = 4
_BEFORE, _AFTER = samples_in(Touches.BEFORE, _RATE), samples_in(Touches.LONGEST, _RATE)


@dataclass(frozen=True, slots=True, eq=False)
class Batch:
    """Unscaled inputs of the network for some contacts, with their true Shore A.

    For each contact, ``row`` is the number of its row of :func:`token_rows`. ``is_known`` is False
    for contacts whose rig has no context.
    """

    x: NDArray[np.float32]
    general: NDArray[np.float32]
    row: NDArray[np.intp]
    is_known: NDArray[np.bool_]
    shore_a: NDArray[np.float64]


def draw_batch(
    examples: Examples,
    indices: NDArray[np.intp],
    rng: Rng,
    samples: int | None = None,
    context: int | None = None,
) -> Batch:
    """Return training inputs for the contacts ``indices``, with random delays and signal lengths.

    ``samples`` fixes the signal length, and ``context`` fixes the context of each rig. A batch with
    a fixed context has no hints.
    """
    n = len(indices)
    shortest, longest = Touches.lengths(_RATE)
    valid = rng.integers(shortest, longest + 1, n) if samples is None else np.full(n, samples)
    place = rng.integers(0, CONTEXTS, n) if context is None else np.full(n, context)
    rig = examples.rigs[indices]
    level, sign = examples.scale[rig, place].T
    general = examples.general[rig, place].copy()
    heard = examples.heard[indices, place]
    has_context = np.ones(n, np.bool_)
    speed, alike = heard[:, 0] / 4, heard[:, 2].astype(np.float64)
    radii = np.full(n, np.nan)
    if context is None:
        has_context = rng.random(n) >= NO_CONTEXT
        measures = rng.random(n) < TOLD_SPEED
        has_speed = measures & (rng.random(n) >= NO_SPEED)
        speed = np.where(has_speed, examples.speeds[indices], speed)
        alike = np.where(has_speed, 1.0, alike)
        general[:, Rig.GENERAL - 1] = measures
        radii[rng.random(n) < TOLD_RADIUS] = 1.0
        radii *= examples.radii[indices]
        # Without a context, the usual speed, the level and the sign of the rig are unknown.
        speed, alike = np.where(has_context, speed, 0.0), np.where(has_context, alike, 0.0)
        level, sign = (
            np.where(has_context, level, Rig.USUAL_LEVEL),
            np.where(has_context, sign, 1.0),
        )
        general[~has_context] = 0.0
    radii = np.where(examples.radii[indices] > MOST / 1000, np.inf, radii)
    signals_after = cut(volts(examples.signals[indices]), placing(rng, examples.has_strips[rig]))
    # The chain takes the signal before a contact, too. No input of the network depends on it.
    signals = np.pad(signals_after, ((0, 0), (_LEAST_BEFORE, 0)))
    hints = facts(speed, alike, radii)
    x, _ = touch_inputs(signals, valid, _LEAST_BEFORE, level, sign, hints)
    row = (rig * CONTEXTS + place) * len(Rig.STAGES) + Rig.stage_index(valid)
    return Batch(x, general, row, has_context, examples.shore_a[indices])


def cut(signals: NDArray[np.float32], late: NDArray[np.intp]) -> NDArray[np.float32]:
    """Return signals from ``late`` samples after each contact on, minus the mean before it."""
    start = _BEFORE + MARGIN + late
    rows = np.arange(len(signals))[:, None]
    end = start - samples_in(BASELINE_GUARD, _RATE)
    baseline = signals[rows, end[:, None] - 1 - np.arange(samples_in(BASELINE, _RATE))].mean(axis=1)
    signals_after = signals[rows, start[:, None] + np.arange(_AFTER)]
    out: NDArray[np.float32] = signals_after - baseline[:, None]
    return out


def token_rows(examples: Examples) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return (features of all rigs' block pinches as rows, mask of the values that exist).

    There is one row per rig, context and signal length. The mask is 1 for each Shore A of the rig's
    blocks.
    """
    present = np.arange(Rig.LEVELS) < examples.levels.reshape(-1, 1)
    return (
        examples.tokens.reshape(-1, Rig.LEVELS, Rig.TOKEN),
        np.repeat(present, len(Rig.STAGES), axis=0).astype(np.float32),
    )
