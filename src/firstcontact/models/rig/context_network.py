"""Weights of the pre-trained network, and statistics of its training contacts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from firstcontact.chain.constants import Layer, Matrix
from firstcontact.chain.touch import INPUTS, TRAITS
from firstcontact.core import ModelError
from firstcontact.core.weights import LARGEST, take_array
from firstcontact.models.rig.rigs import Rig

Arrays = Mapping[str, NDArray[Any]]

#: Largest magnitude of a term of a rig.
_MOST = 1e6


class ContextNetwork:
    """Weights of the pre-trained network, a perceptron whose second layer a rig's summary shifts.

    Matrices hold 16-bit integers, with one scale per row.
    """

    #: Number of standard deviations from the mean at which inputs are clipped.
    FARTHEST: ClassVar[float] = 6.0
    #: Number of components of the predicted mixture.
    COMPONENTS: ClassVar[int] = 3
    #: Thin layers, in order. The rig enters in the second.
    THIN: ClassVar[tuple[str, ...]] = ("query1", "body1", "body2", "body3")

    def __init__(self, arrays: Arrays) -> None:
        self._arrays: dict[str, NDArray[Any]] = {}
        for name, size in (("inputs", INPUTS), ("token", Rig.TOKEN), ("general", Rig.GENERAL)):
            self._take(arrays, f"{name}.mean", size)
            if not self._take(arrays, f"{name}.sd", size).min() >= 1 / LARGEST:
                raise ModelError(
                    f"the array '{name}.sd' has values below {1 / LARGEST:g}: make the model again"
                )
        width = INPUTS
        for name in self.THIN:
            directions = self._store_integers(arrays, f"{name}.into", width)
            width = self._store_integers(arrays, f"{name}.out", directions)
            self._take(arrays, f"{name}.out.bias", width)
        self._take(arrays, "answer.weight", 3 * self.COMPONENTS, width)
        self._take(arrays, "answer.bias", 3 * self.COMPONENTS)
        width = Rig.TOKEN
        for name in ("token1", "token2"):
            width = len(self._take(arrays, f"{name}.weight", None, width))
            self._take(arrays, f"{name}.bias", width)
        heads = len(self._take(arrays, "pool.weight", None, width))
        self._take(arrays, "term.weight", self.directions, (1 + heads) * width + Rig.GENERAL + 1)

    def _take(self, arrays: Arrays, name: str, *shape: int | None) -> NDArray[Any]:
        array = np.ascontiguousarray(take_array(arrays, name, *shape), dtype=np.float32)
        self._arrays[name] = array
        return array

    def _store_integers(self, arrays: Arrays, name: str, columns: int) -> int:
        """Check and store a matrix of 16-bit integers with its scales. Return the number of rows.

        Raise ModelError if the matrix is missing or has another number of ``columns``.
        """
        weight = arrays.get(f"{name}.weight", np.zeros(0))
        if weight.dtype != np.int16 or weight.ndim != 2 or weight.shape[1] != columns:
            raise ModelError(
                f"the array '{name}.weight' is missing, or is not a matrix of 16-bit integers with "
                f"{columns} columns"
            )
        self._arrays[f"{name}.weight"] = weight
        self._take(arrays, f"{name}.scale", len(weight))
        return len(weight)

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        return dict(self._arrays)

    def __getitem__(self, name: str) -> NDArray[Any]:
        return self._arrays[name]

    @property
    def directions(self) -> int:
        """Length of the vector by which a rig shifts the second layer."""
        return len(self["body1.into.weight"])

    @property
    def layers(self) -> list[Layer]:
        """Hidden layers in order, each the product of two thin matrices."""

        def matrix(name: str) -> Matrix:
            return Matrix(self[f"{name}.weight"], self[f"{name}.scale"])

        return [
            Layer(matrix(f"{n}.into"), matrix(f"{n}.out"), self[f"{n}.out.bias"]) for n in self.THIN
        ]

    def rig_term(self, tokens: NDArray[Any], general: NDArray[Any]) -> NDArray[np.float32]:
        """Return the vectors that a rig adds to the input of the network's second layer.

        The shape is (signal lengths, inputs of the layer). ``tokens`` are features of the rig for
        each signal length and Shore A, ``general`` those for the whole rig; see :class:`Rig`. Raise
        ModelError if the weights are so large that predictions may overflow.
        """
        with np.errstate(over="ignore", invalid="ignore"):
            e = self._scaled("token", tokens)
            for name in ("token1", "token2"):
                e = e @ self[f"{name}.weight"].T + self[f"{name}.bias"]
                e = e / (1 + np.exp(-np.maximum(e, -60)))
            stages, levels, width = e.shape
            pool = self["pool.weight"]
            means = np.zeros((stages, 1 + len(pool), width))
            if levels:  # the mean over the levels of Shore A, then weighted means
                fit = e @ pool.T
                share = np.exp(fit - fit.max(axis=1, keepdims=True))
                share /= share.sum(axis=1, keepdims=True)
                means[:, 0] = e.mean(axis=1)
                means[:, 1:] = share.transpose(0, 2, 1) @ e
            rig_wide = np.repeat(self._scaled("general", general)[None], stages, axis=0)
            has_level = np.full((stages, 1), float(levels > 0))
            described = np.concatenate([means.reshape(stages, -1), rig_wide, has_level], axis=1)
            term: NDArray[np.float64] = described @ self["term.weight"].T.astype(np.float64)
        if not (np.abs(term) < _MOST).all():
            raise ModelError(
                "the network's weights are so large that predictions can overflow: train again"
            )
        return term.astype(np.float32)

    def _scaled(self, name: str, x: NDArray[Any]) -> NDArray[np.float64]:
        away = (x.astype(np.float32) - self[f"{name}.mean"]) / self[f"{name}.sd"]
        out: NDArray[np.float64] = np.clip(away, -self.FARTHEST, self.FARTHEST).astype(np.float64)
        return out


@dataclass(frozen=True, slots=True, eq=False)
class Familiar:
    """Statistics of the training signals' features, by which a contact is found out of range.

    They are a mean, a whitening matrix, and the largest distance from the mean, for each signal
    length.
    """

    mean: NDArray[np.float64]
    whitening: NDArray[np.float64]
    limit: NDArray[np.float64]

    def __post_init__(self) -> None:
        shapes = ((len(Rig.STAGES), TRAITS), (len(Rig.STAGES), TRAITS, TRAITS), (len(Rig.STAGES),))
        if (self.mean.shape, self.whitening.shape, self.limit.shape) != shapes:
            raise ModelError(
                "the shapes or values of the arrays that decide if a contact is out of range do "
                "not fit together: make the model again"
            )

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        return {
            "familiar.mean": self.mean,
            "familiar.whitening": self.whitening.astype(np.float32),
            "familiar.limit": self.limit,
        }

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Familiar:
        """Restore the statistics from arrays of these names.

        Raise ModelError if one does not fit.
        """
        shape = (len(Rig.STAGES), TRAITS)
        mean = take_array(arrays, "familiar.mean", *shape)
        whitening = take_array(arrays, "familiar.whitening", *shape, TRAITS)
        limit = take_array(arrays, "familiar.limit", len(Rig.STAGES))
        return cls(*(a.astype(np.float64) for a in (mean, whitening, limit)))
