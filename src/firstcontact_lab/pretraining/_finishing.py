"""Calibration of a trained network: widths of intervals, and limits for out-of-range contacts.

Both are computed on rigs that were not used for training.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import FINGERTIP_RATE
from firstcontact.models import (
    ANY,
    LONGEST,
    STAGES,
    Familiar,
    InContextModel,
    Network,
    Rig,
    Values,
    mean_and_spread,
    traits,
)
from firstcontact.signal import samples_in
from firstcontact_lab.pretraining._batches import cut, draw_batch
from firstcontact_lab.pretraining._examples import CONTEXTS, MARGIN, Examples, volts

#: Nominal coverage of the intervals.
LEVEL = 0.9


def answers(
    network: Network, examples: Examples, samples: int, seed: int = 0
) -> tuple[Values, Values]:
    """Return the prediction and its spread for each contact, two arrays of shape (n,).

    The prediction uses the first ``samples`` samples of a contact, and all block pinches of its
    rig.
    """
    rng = np.random.default_rng([seed, samples])
    everything = np.arange(len(examples))
    batch = draw_batch(examples, everything, rng, samples, context=0)
    values, spreads = np.empty(len(examples)), np.empty(len(examples))
    stage = int(batch.row[0] % len(STAGES))
    for rig in np.unique(examples.rigs):
        indices = np.flatnonzero(examples.rigs == rig)
        count = int(examples.levels[rig, 0])
        context = network.context(examples.tokens[rig, 0, :, :count], examples.general[rig, 0])
        mixture = network.outputs(batch.x[indices], context, np.full(len(indices), stage))
        values[indices], spreads[indices] = mean_and_spread(mixture)
    return values, spreads


def finished(network: Network, examples: Examples, seed: int) -> InContextModel:
    """Return the network as a model with calibrated intervals, not conditioned on a rig.

    Parameters
    ----------
    network
        Trained network.
    examples
        Examples of rigs on which the network was not trained.
    seed
        Random seed.
    """
    factors = np.array([_factor(network, examples, stage, seed) for stage in STAGES])
    seen = [_traits(examples, stage, seed) for stage in STAGES]
    return InContextModel(network, Familiar.fit(seen), factors, LEVEL, {ANY: Rig.unknown()})


def _factor(network: Network, examples: Examples, samples: int, seed: int) -> float:
    """Return half width / spread of intervals that hold the truth in the share ``LEVEL``.

    The method is split conformal prediction; the score is error / spread (Papadopoulos et al.
    2008).
    """
    values, spreads = answers(network, examples, samples, seed)
    is_object = examples.object_ids >= 0
    score = np.abs(values - examples.shore_a) / spreads
    ordered = np.sort(score[is_object])
    rank = math.ceil((len(ordered) + 1) * LEVEL)
    return float(ordered[min(rank, len(ordered)) - 1])


def _traits(examples: Examples, samples: int, seed: int) -> NDArray[np.float64]:
    rng = np.random.default_rng([seed, samples, 1])
    signals = volts(examples.signals)
    late = np.zeros(len(signals), np.intp)
    longest = samples_in(LONGEST, FINGERTIP_RATE)
    length_before = signals.shape[1] - longest - 2 * MARGIN
    signals_after = cut(signals, late + rng.integers(0, 4, len(signals)))
    full = np.concatenate([signals[:, MARGIN : MARGIN + length_before], signals_after], axis=1)
    level, sign = examples.scale[examples.rigs, rng.integers(0, CONTEXTS, len(signals))].T
    return traits(full, length_before, np.full(len(signals), samples), level, sign)
