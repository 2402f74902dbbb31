"""The in-context network's arithmetic, in NumPy: it runs where there is no PyTorch."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.anytime.inputs import INPUTS
from firstcontact.anytime.rig import GENERAL, TOKEN
from firstcontact.core import InputError

Arrays = Mapping[str, NDArray[Any]]
Matrix = NDArray[np.float32]

#: Inputs are cut off so many standard deviations from their mean.
FARTHEST = 6.0
#: Components of the answer's mixture, and heads that look at the context.
COMPONENTS, HEADS = 3, 4
#: Unit of the outputs: Shore A is CENTRE + UNIT times them.
CENTRE, UNIT = 40.0, 40.0
#: Layers by name: what they take is checked when weights are read.
LAYERS = ("token1", "token2", "mean", "key", "value", "query1", "query2", "body1", "body2",
          "body3", "answer")  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class Context:
    """What the network makes of a rig, for each stage; made once.

    Parameters
    ----------
    mean
        Mean over the levels of Shore A, shape (stages, width).
    keys, values
        What heads look for and find at each level, shape (stages, HEADS, levels, width).
    general
        Shape (GENERAL,).
    """

    mean: Matrix
    keys: Matrix
    values: Matrix
    general: Matrix


class Network:
    """A perceptron that looks at the rig's levels of Shore A by attention.

    Parameters
    ----------
    arrays
        ``LAYER.weight`` (outputs, inputs) and ``LAYER.bias`` of each of ``LAYERS``, and
        ``inputs.mean``, ``inputs.sd``, likewise ``token`` and ``general``.

    Raises
    ------
    InputError
        Arrays that are missing or do not fit together.
    """

    def __init__(self, arrays: Arrays) -> None:
        try:
            self._layers = {
                name: (_matrix(arrays[f"{name}.weight"], 2), _matrix(arrays[f"{name}.bias"], 1))
                for name in LAYERS
            }
            self._scales = {
                name: (_matrix(arrays[f"{name}.mean"], 1), _matrix(arrays[f"{name}.sd"], 1))
                for name in ("inputs", "token", "general")
            }
        except KeyError as error:
            raise InputError(f"the array {error} of the network is missing") from None
        self._check()

    def _check(self) -> None:
        wide = {name: weight.shape for name, (weight, _) in self._layers.items()}
        hidden, context = wide["query1"][0], wide["mean"][0]
        chain = {
            "token1": TOKEN,
            "token2": wide["token1"][0],
            "mean": wide["token2"][0],
            "key": wide["token2"][0],
            "value": wide["token2"][0],
            "query1": INPUTS,
            "query2": hidden,
            "body1": hidden + context + wide["value"][0] + GENERAL,
            "body2": wide["body1"][0],
            "body3": wide["body2"][0],
            "answer": wide["body3"][0],
        }
        sizes = {"inputs": INPUTS, "token": TOKEN, "general": GENERAL}
        if (
            any(wide[name][1] != taken for name, taken in chain.items())
            or any(len(bias) != len(weight) for weight, bias in self._layers.values())
            or wide["answer"][0] != 3 * COMPONENTS
            or wide["key"][0] != wide["query2"][0]
            or wide["key"][0] % HEADS
            or wide["value"][0] % HEADS
            or any(self._scales[n][k].shape != (s,) for n, s in sizes.items() for k in (0, 1))
            or any((sd <= 0).any() for _, sd in self._scales.values())
        ):
            raise InputError("the arrays of the network do not fit together")

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """The inverse of the constructor."""
        out: dict[str, NDArray[Any]] = {}
        for name, (weight, bias) in self._layers.items():
            out[f"{name}.weight"], out[f"{name}.bias"] = weight, bias
        for name, (mean, sd) in self._scales.items():
            out[f"{name}.mean"], out[f"{name}.sd"] = mean, sd
        return out

    def context(self, tokens: NDArray[Any], general: NDArray[Any]) -> Context:
        """What it makes of a rig.

        Parameters
        ----------
        tokens, general
            As of :class:`firstcontact.anytime.rig.Rig`.
        """
        e = self._silu("token2", self._silu("token1", self._scaled("token", tokens)))
        stages, levels, _ = e.shape

        def heads(name: str) -> Matrix:
            width = len(self._layers[name][1]) // HEADS
            split = self._linear(name, e).reshape(stages, levels, HEADS, width)
            return np.ascontiguousarray(split.transpose(0, 2, 1, 3))

        if not levels:  # nothing is known of the rig
            width = self._layers["mean"][0].shape[0]
            mean: Matrix = np.zeros((stages, width), np.float32)
            return Context(mean, heads("key"), heads("value"), self._scaled("general", general))
        mean = self._linear("mean", e).mean(axis=1)
        return Context(mean, heads("key"), heads("value"), self._scaled("general", general))

    def outputs(
        self, x: NDArray[Any], context: Context, stages: NDArray[np.intp]
    ) -> NDArray[np.float64]:
        """Mixture of normals for each contact.

        Parameters
        ----------
        x
            Inputs, shape (n, INPUTS).
        context
            Of the rig.
        stages
            Of the context, shape (n,).

        Returns
        -------
        ndarray
            Weights, means and standard deviations of the components, the latter two in
            Shore A, shape (3, n, COMPONENTS).
        """
        h = self._silu("query1", self._scaled("inputs", x))
        query = self._linear("query2", h).reshape(len(h), HEADS, 1, -1)
        keys, values = context.keys[stages], context.values[stages]
        fit = (query * keys).sum(axis=-1) / np.float32(np.sqrt(query.shape[-1]))
        share = np.exp(fit - fit.max(axis=-1, keepdims=True, initial=-np.inf))
        share /= share.sum(axis=-1, keepdims=True)
        found = (share[..., None] * values).sum(axis=2).reshape(len(h), -1)
        general = context.general[None].repeat(len(h), axis=0)
        body: Matrix = np.concatenate([h, context.mean[stages], found, general], axis=1)
        for name in ("body1", "body2", "body3"):
            body = self._silu(name, body)
        raw = self._linear("answer", body).astype(np.float64)
        out = raw.reshape(len(h), 3, COMPONENTS).transpose(1, 0, 2).copy()
        weight, mean, spread = out
        np.exp(weight - weight.max(axis=1, keepdims=True), out=weight)
        weight /= weight.sum(axis=1, keepdims=True)
        mean *= UNIT * MEAN_SCALE
        mean += CENTRE
        np.exp(spread.clip(*SPREAD), out=spread)
        spread *= UNIT
        return out

    def _scaled(self, name: str, x: NDArray[Any]) -> Matrix:
        mean, sd = self._scales[name]
        scaled = (x.astype(np.float32) - mean) / sd
        out: Matrix = np.minimum(np.maximum(scaled, -FARTHEST), FARTHEST)  # quicker than clip
        return out

    def _linear(self, name: str, x: Matrix) -> Matrix:
        weight, bias = self._layers[name]
        out: Matrix = x @ weight.T
        out += bias
        return out

    def _silu(self, name: str, x: Matrix) -> Matrix:
        y = self._linear(name, x)
        # Bounded from below alone: far above 0 the exponential vanishes.
        e = np.exp(-np.maximum(y, np.float32(-60)))
        e += 1
        y /= e
        return y


#: Bounds of ln(standard deviation / UNIT), and the unit of the means at the start of training.
SPREAD = (-4.0, 2.0)
MEAN_SCALE = 0.6


def _matrix(array: NDArray[Any], dimensions: int) -> Matrix:
    if array.ndim != dimensions or not np.isfinite(array).all():
        raise InputError("an array of the network does not fit, or holds what is no number")
    return np.ascontiguousarray(array, dtype=np.float32)
