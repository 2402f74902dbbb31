"""Statistics of the training contacts, with which the chain finds contacts that are out of range.

The traits of a contact are the numbers that are compared with the training data: the features of
its signal, the noise before it, and the share of repeated samples.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.chain import TRAITS
from firstcontact.core import InputError, take_array
from firstcontact.models._rig import STAGES

#: Share of the training contacts that is marked out of range.
FALSE_ALARMS = 0.01
#: Added to the variance of each trait, so that small differences of gain between sessions do not
#: count.
_SHRINK = 1e-3


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
