"""What the network is shown of a set of examples, drawn anew each time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import FINGERTIP_RATE
from firstcontact.models import (
    BEFORE,
    GENERAL,
    LEVELS,
    LONGEST,
    STAGES,
    TOKEN,
    USUAL_LEVEL,
    facts,
    lengths,
    relative_inputs,
    stage_of,
)
from firstcontact.signal import BASELINE, BASELINE_GUARD, samples_in
from firstcontact.twin import Rng
from firstcontact_lab.pretraining._examples import CONTEXTS, MARGIN, Examples, placing, volts

#: Shares of contacts of which nothing is known of the rig, whose closing speed is told, and
#: whose radius is told.
NO_CONTEXT, TOLD_SPEED, TOLD_RADIUS = 0.08, 0.2, 0.3
_RATE = FINGERTIP_RATE
_BEFORE, _AFTER = samples_in(BEFORE, _RATE), samples_in(LONGEST, _RATE)


@dataclass(frozen=True, slots=True, eq=False)
class Batch:
    """Inputs that are not scaled yet, and the target.

    Parameters
    ----------
    x, general
        Shape (n, INPUTS) and (n, GENERAL).
    row
        Place of the tokens among all tokens of the set, see :func:`token_rows`, shape (n,).
    known
        Whether anything is known of the rig, shape (n,).
    shore_a
        Shape (n,).
    """

    x: NDArray[np.float32]
    general: NDArray[np.float32]
    row: NDArray[np.intp]
    known: NDArray[np.bool_]
    shore_a: NDArray[np.float64]


def draw_batch(
    examples: Examples,
    which: NDArray[np.intp],
    rng: Rng,
    samples: int | None = None,
    context: int | None = None,
) -> Batch:
    """Contacts as they might have been placed, after some time, beside one of the contexts.

    Parameters
    ----------
    examples
        The set.
    which
        Positions in it, shape (n,).
    rng
        Of all that is drawn.
    samples
        Valid ones after each contact; None draws them.
    context
        Which of the contexts, with nothing told; None draws one, and what is told.
    """
    n = len(which)
    shortest, longest = lengths(_RATE)
    valid = rng.integers(shortest, longest + 1, n) if samples is None else np.full(n, samples)
    place = rng.integers(0, CONTEXTS, n) if context is None else np.full(n, context)
    rig = examples.rigs[which]
    level, sign = examples.scale[rig, place].T
    general = examples.general[rig, place].copy()
    heard = examples.heard[which, place]
    known = np.ones(n, np.bool_)
    speed, alike = heard[:, 0] / 4, heard[:, 2].astype(np.float64)
    radii = np.full(n, np.nan)
    if context is None:
        known = rng.random(n) >= NO_CONTEXT
        told = rng.random(n) < TOLD_SPEED
        speed = np.where(told, examples.speeds[which], speed)
        alike = np.where(told, 1.0, alike)
        general[:, GENERAL - 1] = told
        radii[rng.random(n) < TOLD_RADIUS] = 1.0
        radii *= examples.radii[which]
        # Nothing is known of the rig: nor its usual speed, nor its level, nor its wiring.
        speed, alike = np.where(known, speed, 0.0), np.where(known, alike, 0.0)
        level, sign = np.where(known, level, USUAL_LEVEL), np.where(known, sign, 1.0)
        general[~known] = 0.0
    after = cut(volts(examples.signals[which]), placing(rng, n))
    x = relative_inputs(after, valid, level, sign, facts(speed, alike, radii))
    row = (rig * CONTEXTS + place) * len(STAGES) + stage_of(valid, _RATE)
    return Batch(x.astype(np.float32), general, row, known, examples.shore_a[which])


def cut(signals: NDArray[np.float32], late: NDArray[np.intp]) -> NDArray[np.float32]:
    """Signals from so many samples after the contacts on, their baselines removed."""
    start = _BEFORE + MARGIN + late
    rows = np.arange(len(signals))[:, None]
    end = start - samples_in(BASELINE_GUARD, _RATE)
    baseline = signals[rows, end[:, None] - 1 - np.arange(samples_in(BASELINE, _RATE))].mean(axis=1)
    after = signals[rows, start[:, None] + np.arange(_AFTER)]
    out: NDArray[np.float32] = after - baseline[:, None]
    return out


def token_rows(examples: Examples) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Tokens of each rig, context and stage in a row, and which levels there are.

    Returns
    -------
    tokens, there : ndarray
        Shape (rows, LEVELS, TOKEN) and (rows, LEVELS).
    """
    there = np.arange(LEVELS) < examples.levels.reshape(-1, 1)
    return (
        examples.tokens.reshape(-1, LEVELS, TOKEN),
        np.repeat(there, len(STAGES), axis=0).astype(np.float32),
    )
