"""Calibration of a pre-trained network on simulated rigs that were not used for training.

It sets the intervals, the limits beyond which a signal is out of range, and the average of pooled
pinches.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.chain.touch import HINTS, TRAITS, predict_inputs, touch_inputs
from firstcontact.core.layout import FINGERTIP_RATE
from firstcontact.jobs import Runner
from firstcontact.models import Touches
from firstcontact.models.predictions import combine
from firstcontact.models.rig.combined import (
    LEAST_LEVELS,
    LEAST_PINCHES,
    average_with_regressions,
    spread_scale,
)
from firstcontact.models.rig.context_network import ContextNetwork, Familiar
from firstcontact.models.rig.rig_model import RigModel
from firstcontact.models.rig.rigs import Rig
from firstcontact.models.values import Values
from firstcontact.signal import samples_in
from firstcontact_lab.pretraining.batches import cut, draw_batch
from firstcontact_lab.pretraining.examples import (
    CONTEXTS,
    MARGIN,
    Examples,
    labelled_touches,
    volts,
)

LEVEL = 0.9
#: Share of the training contacts that is marked out of range.
FALSE_ALARMS = 0.01
#: Added to the variance of each trait, so that small differences of gain between sessions do not
#: count.
_SHRINK = 1e-3


def answers(
    model: RigModel, examples: Examples, samples: int, seed: int = 0
) -> tuple[Values, Values]:
    """Return (predicted Shore A, standard deviations), with one value per contact.

    The model gets ``samples`` samples after each contact.
    """
    rng = np.random.default_rng([seed, samples])
    everything = np.arange(len(examples))
    batch = draw_batch(examples, everything, rng, samples, context=0)
    values, spreads = np.empty(len(examples)), np.empty(len(examples))
    stage = int(batch.row[0] % len(Rig.STAGES))
    for rig in np.unique(examples.rigs):
        indices = np.flatnonzero(examples.rigs == rig)
        count = int(examples.levels[rig, 0])
        tokens, general = examples.tokens[rig, 0, :, :count], examples.general[rig, 0]
        term = model.network.rig_term(tokens, general)[stage]
        terms = np.repeat(term[None], len(indices), axis=0)
        values[indices], spreads[indices] = predict_inputs(model.image, batch.x[indices], terms).T
    return values, spreads


def calibrate_network(network: ContextNetwork, examples: Examples, seed: int) -> RigModel:
    """Return the trained network as a model for any rig, with calibrated intervals."""
    familiar = _familiar([_traits(examples, stage, seed) for stage in Rig.STAGES])
    ones = np.ones(len(Rig.STAGES))
    plain = RigModel(network, familiar, ones, LEVEL, {Rig.ANY: Rig.unknown()}, ones)
    return plain.rescaled(np.array([_factor(plain, examples, stage, seed) for stage in Rig.STAGES]))


def calibrate_average(
    model: RigModel, numbers: Sequence[int], seed: int, runner: Runner
) -> RigModel:
    """Return the model with intervals for the average of network and regression as well.

    ``numbers`` are the rigs on which they are calibrated.
    """
    errors, spreads = object_errors(model, numbers, seed, runner)[1]
    factors = np.array([_quantile(of_stage) for of_stage in np.abs(errors) / spreads])
    return RigModel(model.network, model.familiar, model.factors, model.level, model.rigs, factors)


def object_errors(
    model: RigModel, numbers: Sequence[int], seed: int, runner: Runner, family: str = ""
) -> NDArray[np.float64]:
    """Return errors and predicted standard deviations of network and average, Shore A.

    The average is that of the network and a regression on the rig's pinches. The shape is (network
    or average, error or deviation, signal lengths, objects). For signals longer than the time to
    the second contact, errors are NaN.
    """
    of_rigs = runner.map(_object_errors, numbers, seed, model, family)
    return np.concatenate([errors for errors in of_rigs if errors.size], axis=3)


def _object_errors(number: int, seed: int, model: RigModel, family: str) -> NDArray[np.float64]:
    blocks, levels, objects, shore_a = labelled_touches(number, seed, family)
    if len(blocks) < LEAST_PINCHES or len(np.unique(levels)) < LEAST_LEVELS:
        return np.zeros((2, 2, len(Rig.STAGES), 0))
    scale = spread_scale(model, blocks, levels, seed)
    average = average_with_regressions(model, blocks, levels, seed, scale)
    out = np.empty((2, 2, len(Rig.STAGES), len(objects)))
    for place, stage in enumerate(Rig.STAGES):
        for row, one in enumerate((average.network_alone(), average)):
            predicted = one.predict_touches(objects.until(stage))
            error = predicted.value - shore_a
            out[row, :, place] = np.where(objects.valid >= stage, error, np.nan), predicted.spread
    return out


def _familiar(traits: Sequence[NDArray[np.float64]]) -> Familiar:
    """Return the limits of familiar signals, computed from the features of many signals.

    The limits are the centre, whitening and largest distance of features. ``traits`` has the
    features for each signal length.
    """
    means, whitenings, limits = [], [], []
    for trait_values in traits:
        mean = np.median(trait_values, axis=0)
        covariance = np.cov(trait_values, rowvar=False) + _SHRINK * np.eye(TRAITS)
        whitening = np.linalg.inv(np.linalg.cholesky(covariance))
        whitened = (trait_values - mean) @ whitening.T
        distance = np.sqrt((whitened * whitened).sum(axis=1))
        means.append(mean)
        whitenings.append(whitening)
        limits.append(np.quantile(distance, 1 - FALSE_ALARMS))
    return Familiar(np.array(means), np.array(whitenings), np.array(limits))


def _factor(model: RigModel, examples: Examples, samples: int, seed: int) -> float:
    """Return the factor from standard deviations to half widths of intervals.

    With this factor, the share ``LEVEL`` of the objects lies within the interval.
    """
    values, spreads = answers(model, examples, samples, seed)
    is_object = examples.object_ids >= 0
    return _quantile((np.abs(values - examples.shore_a) / spreads)[is_object])


def _quantile(ratios: Values) -> float:
    """Return the conformal quantile of ratios of error to standard deviation, without NaN."""
    ordered = np.sort(ratios[np.isfinite(ratios)])
    rank = math.ceil((len(ordered) + 1) * LEVEL)
    return float(ordered[min(rank, len(ordered)) - 1])


def _traits(examples: Examples, samples: int, seed: int) -> NDArray[np.float64]:
    rng = np.random.default_rng([seed, samples, 1])
    signals = volts(examples.signals)
    late = np.zeros(len(signals), np.intp)
    longest = samples_in(Touches.LONGEST, FINGERTIP_RATE)
    length_before = signals.shape[1] - longest - 2 * MARGIN
    signals_after = cut(signals, late + rng.integers(0, 4, len(signals)))
    full = np.concatenate([signals[:, MARGIN : MARGIN + length_before], signals_after], axis=1)
    level, sign = examples.scale[examples.rigs, rng.integers(0, CONTEXTS, len(signals))].T
    valid, no_hints = np.full(len(signals), samples), np.zeros((len(signals), HINTS))
    return touch_inputs(full, valid, length_before, level, sign, no_hints)[1]


#: Number of pinches of each object, all in one session.
PINCHES = 5


def object_estimates(
    model: RigModel, examples: Examples, samples: int, seed: int
) -> tuple[Values, Values, Values]:
    """Return (predictions, half widths of their intervals, true Shore A of each object).

    The shapes are (objects, pinches), (objects, pinches) and (objects,). ``samples`` is the signal
    length.
    """
    values, spreads = answers(model, examples, samples, seed)
    half = model.half_widths(spreads, samples)
    is_object = examples.object_ids >= 0
    value, width, truth = (
        x[is_object].reshape(-1, PINCHES) for x in (np.clip(values, 0, 100), half, examples.shore_a)
    )
    return value, width, truth[:, 0]


def shared_part(values: Values, half_widths: Values, truth: Values) -> float:
    """Return the share of the error that all pinches of an object have in common.

    The arguments are the result of :func:`object_estimates`.
    """
    z = (values - truth[:, None]) / half_widths
    n = z.shape[1]
    products = (z.sum(axis=1) ** 2 - (z**2).sum(axis=1)).mean() / (n * (n - 1))
    return float(np.sqrt(max(products, 0.0) / (z**2).mean()))


def coverage(values: Values, half_widths: Values, truth: Values, pinches: int) -> float:
    """Return the share of objects whose Shore A lies in an interval from pooled pinches.

    Each interval pools ``pinches`` pinches of the object.
    """
    combined = [combine(v[:pinches], h[:pinches]) for v, h in zip(values, half_widths, strict=True)]
    covered = [
        estimates.low <= y <= estimates.high for estimates, y in zip(combined, truth, strict=True)
    ]
    return float(np.mean(covered))


def same_object(
    model: RigModel,
    calibration: Examples,
    test: Examples,
    samples: Mapping[str, int],
    seed: int,
) -> dict[str, Any]:
    """Return the shared part of the error and the coverages of pooled pinches, by time.

    ``samples`` maps the name of a time to the signal length. The result can be written as JSON.
    """
    out = {}
    for time, length in samples.items():
        estimates = object_estimates(model, test, length, seed)
        out[time] = {
            "shared": round(shared_part(*object_estimates(model, calibration, length, seed)), 3),
            "coverage": {str(n): round(coverage(*estimates, n), 3) for n in range(1, PINCHES + 1)},
        }
    return {"pinches": PINCHES, "ms": out}
