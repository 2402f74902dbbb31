"""Detection of contacts that are unlike the training data.

The traits of a contact are the numbers that are compared with the training data: the features of
its signal, the noise before it, and the share of repeated samples.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import InputError, take_array
from firstcontact.models._contact_features import NAMES, Shape
from firstcontact.models._rig import STAGES

#: Traits of a contact: features, the noise before the contact, and the share of flat samples.
TRAITS = len(NAMES) + 2
#: Share of repeated samples above which a converter counts as dead or saturated.
STILL = 0.5
#: Share of the training contacts that is marked out of range.
FALSE_ALARMS = 0.01
#: Mask of the traits that move when the gain of the sensor changes: the direction of the gain.
GAIN = np.isin(np.arange(TRAITS), [NAMES.index(n) for n in ("peak", "steepest rise", "power")])
GAIN[len(NAMES)] = True  # the noise before the contact
#: Added to the variance of each trait, so that small differences of gain between sessions do not
#: count.
_SHRINK = 1e-3


def traits(
    signals: NDArray[np.floating],
    lead: int,
    valid: NDArray[np.intp],
    level: NDArray[np.float64],
    sign: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return the traits of contacts, shape (n, TRAITS).

    Parameters
    ----------
    signals, lead, valid
        As in :class:`firstcontact.models._touches.Touches`.
    level, sign
        Level (V) and sign of each contact's rig, shape (n,).
    """
    return shape_traits(Shape.measure(signals[:, lead:], valid, level, sign), signals[:, :lead])


def shape_traits(shape: Shape, lead_signals: NDArray[np.floating]) -> NDArray[np.float64]:
    """Return the traits of contacts from their `Shape` and the signal before them."""
    # A saturated or dead converter repeats its value.
    counted = shape.is_valid[:, 1:]
    still = (shape.v[:, 1:] == shape.v[:, :-1]) & counted
    flat = still.sum(axis=1) / counted.sum(axis=1)
    loud = pre_contact_noise(lead_signals, shape.level)
    return np.concatenate([shape.features, loud[:, None], 10 * flat[:, None]], axis=1)


def pre_contact_noise(
    lead_signals: NDArray[np.floating], level: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the logarithm of the noise before contacts, relative to the level, shape (n,)."""
    noise = lead_signals[:, : lead_signals.shape[1] // 2].std(axis=1)
    loud: NDArray[np.float64] = np.log(np.maximum(noise, 1e-7) / level)
    return loud


def still(trait_values: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return a mask of the contacts whose sensor is dead, or clipped half of the time, shape (n,).

    ``trait_values`` holds the traits of the contacts, shape (n, TRAITS).
    """
    out: NDArray[np.bool_] = trait_values[:, -1] > 10 * STILL
    return out


@dataclass(frozen=True, slots=True, eq=False)
class Familiar:
    """Statistics of the traits of training contacts, at each stage.

    Parameters
    ----------
    mean, whitening
        Centre (median) and whitening matrix of the traits, shape (stages, TRAITS) and (stages,
        TRAITS, TRAITS).
    limit
        Largest distance from the centre for a contact that is not out of range, shape (stages,).

    Raises
    ------
    InputError
        Arrays do not fit together.
    """

    mean: NDArray[np.float64]
    whitening: NDArray[np.float64]
    limit: NDArray[np.float64]

    def __post_init__(self) -> None:
        shapes = ((len(STAGES), TRAITS), (len(STAGES), TRAITS, TRAITS), (len(STAGES),))
        if (self.mean.shape, self.whitening.shape, self.limit.shape) != shapes:
            raise InputError(
                "the shapes or values of the arrays that decide if a contact is out of range do "
                "not fit together: make the model again"
            )

    @classmethod
    def fit(cls, seen: list[NDArray[np.float64]]) -> Familiar:
        """Fit centre, covariance and limit of the traits at each stage.

        ``seen`` holds one array of traits per stage, shape (contacts, TRAITS).
        """
        means, whitenings, limits = [], [], []
        for trait_values in seen:
            mean = np.median(trait_values, axis=0)
            covariance = np.cov(trait_values, rowvar=False) + _SHRINK * np.eye(TRAITS)
            whitening = np.linalg.inv(np.linalg.cholesky(covariance))
            distance = _distance(trait_values - mean, whitening)
            means.append(mean)
            whitenings.append(whitening)
            limits.append(np.quantile(distance, 1 - FALSE_ALARMS))
        return cls(np.array(means), np.array(whitenings), np.array(limits))

    def out_of_range(
        self, trait_values: NDArray[np.float64], stages: NDArray[np.intp], has_level: bool = True
    ) -> NDArray[np.bool_]:
        """Return which of n contacts are out of range at their ``stages``, shape (n,).

        ``trait_values`` are the traits of the contacts, shape (n, TRAITS). If ``has_level`` is
        False, the rig's level is unknown. Each contact then gets the gain that brings it closest to
        the training contacts, and signals of a dead or clipped sensor are always out of range.
        """
        far = trait_values - self.mean[stages]
        # The training contacts of a stage have one length, so any other length would count as
        # unfamiliar.
        far[:, NAMES.index("length")] = 0.0
        away = np.einsum("nij,nj->ni", self.whitening[stages], far)
        square = (away * away).sum(axis=1)
        if not has_level:
            along = self.whitening @ GAIN
            along /= np.maximum(np.linalg.norm(along, axis=1), 1e-30)[:, None]
            square = np.maximum(square - np.einsum("ni,ni->n", away, along[stages]) ** 2, 0.0)
        out: NDArray[np.bool_] = np.sqrt(square) > self.limit[stages]
        return out if has_level else out | still(trait_values)

    def is_out_of_range(
        self, trait_values: NDArray[np.float64], stage: int, has_level: bool = True
    ) -> bool:
        """Return True if a contact with these traits, shape (TRAITS,), is out of range."""
        if not has_level:
            stages = np.full(1, stage, np.intp)
            return bool(self.out_of_range(trait_values[None], stages, has_level)[0])
        far = trait_values - self.mean[stage]
        far[NAMES.index("length")] = 0.0
        away = self.whitening[stage] @ far
        return bool(np.sqrt(away @ away) > self.limit[stage])

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Return the arrays by name, for :meth:`from_arrays`."""
        return {
            "familiar.mean": self.mean,
            "familiar.whitening": self.whitening.astype(np.float32),
            "familiar.limit": self.limit,
        }

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Familiar:
        """Restore from arrays of :meth:`to_arrays`; InputError if they do not fit."""
        shape = (len(STAGES), TRAITS)
        mean = take_array(arrays, "familiar.mean", *shape)
        whitening = take_array(arrays, "familiar.whitening", *shape, TRAITS)
        limit = take_array(arrays, "familiar.limit", len(STAGES))
        return cls(*(a.astype(np.float64) for a in (mean, whitening, limit)))


def _distance(away: NDArray[np.float64], whitening: NDArray[np.float64]) -> NDArray[np.float64]:
    whitened = away @ whitening.T
    out: NDArray[np.float64] = np.sqrt((whitened * whitened).sum(axis=1))
    return out
