"""Arithmetic of the network in NumPy. It needs no PyTorch."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import LARGEST, InputError, take_array
from firstcontact.models._network_inputs import INPUTS
from firstcontact.models._rig import GENERAL, TOKEN

Arrays = Mapping[str, NDArray[Any]]
Matrix = NDArray[np.float32]

#: Number of standard deviations from the mean at which inputs are clipped.
FARTHEST = 6.0
#: Number of components of the predicted mixture, and number of attention heads.
COMPONENTS, HEADS = 3, 4
#: Scale of the outputs: Shore A is CENTRE + UNIT times an output.
CENTRE, UNIT = 40.0, 40.0
#: Names of the layers. Their shapes are checked when weights are read.
LAYERS = ("token1", "token2", "mean", "key", "value", "query1", "query2", "body1", "body2",
          "body3", "answer")  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class Context:
    """Encoded rig: input of the network at each stage, computed once.

    Parameters
    ----------
    mean
        Mean of the encoded levels of Shore A, shape (stages, width).
    keys, values
        Attention keys and values of each level, shape (stages, HEADS, levels, width).
    general
        Features of the rig as a whole, shape (GENERAL,).
    """

    mean: Matrix
    keys: Matrix
    values: Matrix
    general: Matrix


class Network:
    """Perceptron with attention to the rig's levels of Shore A.

    Parameters
    ----------
    arrays
        ``LAYER.weight`` (outputs, inputs) and ``LAYER.bias`` for each of ``LAYERS``; ``NAME.mean``
        and ``NAME.sd`` for the names ``inputs``, ``token`` and ``general``.

    Raises
    ------
    InputError
        Arrays are missing or do not fit together.
    """

    def __init__(self, arrays: Arrays) -> None:
        self._layers: dict[str, tuple[Matrix, Matrix]] = {}
        for name in LAYERS:
            weight = take_array(arrays, f"{name}.weight", None, None)
            bias = take_array(arrays, f"{name}.bias", len(weight))
            self._layers[name] = _single(weight), _single(bias)
        self._scales: dict[str, tuple[Matrix, Matrix]] = {}
        for name, size in (("inputs", INPUTS), ("token", TOKEN), ("general", GENERAL)):
            mean, sd = (take_array(arrays, f"{name}.{part}", size) for part in ("mean", "sd"))
            self._scales[name] = _single(mean), _single(sd)
        self._check_sizes()
        self.check_reach()

    def _check_sizes(self) -> None:
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
        for name, inputs in chain.items():
            outputs: int = wide["query2" if name == "key" else name][0]
            outputs = 3 * COMPONENTS if name == "answer" else outputs
            fits = outputs % (HEADS if name in ("key", "value") else 1) == 0 < outputs
            if wide[name] != (outputs, inputs) or not fits:
                raise InputError(
                    f"the array '{name}.weight' has the shape {wide[name]}, which does not fit "
                    f"{inputs} inputs, {HEADS} heads and the layers after it"
                )

    def check_reach(self) -> None:
        """Refuse weights if an intermediate number of a prediction could overflow.

        Inputs are clipped, so each layer has a largest output for any contact.

        Raises
        ------
        InputError
            The outputs of a layer may overflow, or a scale of its inputs is too small. The message
            names the layer or the array.
        """
        for name, (_, sd) in self._scales.items():
            if not sd.min() >= 1 / LARGEST:
                raise InputError(f"the array '{name}.sd' has values below {1 / LARGEST:g}")
        reach: dict[str, float] = {}

        def layer(name: str, most: float) -> float:
            reach[name] = self._most(name, most)
            return reach[name]

        with np.errstate(over="ignore", invalid="ignore"):
            token = layer("token2", layer("token1", FARTHEST))
            hidden = layer("query1", FARTHEST)
            constants = [FARTHEST, hidden, *(layer(name, token) for name in ("mean", "value"))]
            fit = layer("query2", hidden) * layer("key", token) * len(self._layers["key"][1])
            body = layer("body3", layer("body2", layer("body1", max(constants))))
            layer("answer", body)
        reach["query2"] = max(reach["query2"], fit)
        for name, most in reach.items():
            if not most < LARGEST:
                raise InputError(
                    f"the outputs of the network's layer '{name}' may overflow: the weights of "
                    "this layer, or of the layers before it, are too large: train the network "
                    "again"
                )

    def _most(self, name: str, most: float) -> float:
        """Return the largest possible output of a layer for inputs of at most ``most``."""
        weight, bias = (np.abs(x.astype(np.float64)) for x in self._layers[name])
        return float((weight.sum(axis=1) * most + bias).max())

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Return the arrays of the constructor."""
        out: dict[str, NDArray[Any]] = {}
        for name, (weight, bias) in self._layers.items():
            out[f"{name}.weight"], out[f"{name}.bias"] = weight, bias
        for name, (mean, sd) in self._scales.items():
            out[f"{name}.mean"], out[f"{name}.sd"] = mean, sd
        return out

    @property
    def layers(self) -> Mapping[str, tuple[Matrix, Matrix]]:
        """Weight and bias of each layer."""
        return self._layers

    def scale(self, name: str) -> tuple[Matrix, Matrix]:
        """Return mean and standard deviation that scale ``inputs``, ``token`` or ``general``."""
        return self._scales[name]

    def context(self, tokens: NDArray[Any], general: NDArray[Any]) -> Context:
        """Return the encoding of a rig, which is an input of the network.

        Parameters
        ----------
        tokens, general
            As in :class:`firstcontact.models._rig.Rig`.
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
        """Return a mixture of normal distributions for each contact.

        Parameters
        ----------
        x
            Inputs, shape (n, INPUTS).
        context
            Encoded rig.
        stages
            Index in ``STAGES`` of the time of each contact, shape (n,).

        Returns
        -------
        ndarray
            Weights, means (Shore A) and standard deviations (Shore A) of the components, shape (3,
            n, COMPONENTS).
        """
        h = self._silu("query1", self._scaled("inputs", x))
        query = self._linear("query2", h).reshape(len(h), HEADS, 1, -1)
        keys, values = context.keys[stages], context.values[stages]
        fit = (query * keys).sum(axis=-1) / np.float32(np.sqrt(query.shape[-1]))
        share = np.exp(fit - fit.max(axis=-1, keepdims=True, initial=-np.inf))
        share /= share.sum(axis=-1, keepdims=True)
        attended = (share[..., None] * values).sum(axis=2).reshape(len(h), -1)
        general = context.general[None].repeat(len(h), axis=0)
        body: Matrix = np.concatenate([h, context.mean[stages], attended, general], axis=1)
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

    def outputs_of_one(
        self, x: NDArray[np.float64], context: Context, stage: int
    ) -> NDArray[np.float64]:
        """Return :meth:`outputs` for the inputs (INPUTS,) of one contact, shape (3, COMPONENTS)."""
        keys, values = context.keys[stage], context.values[stage]
        h = self._silu("query1", self._scaled("inputs", x))
        query = self._linear("query2", h).reshape(HEADS, 1, -1)
        fit = (query * keys).sum(axis=-1)
        fit /= np.float32(math.sqrt(query.shape[-1]))
        share: Matrix = np.exp(fit - fit.max(axis=-1, keepdims=True, initial=-np.inf))
        share /= share.sum(axis=-1, keepdims=True)
        attended = (share[..., None] * values).sum(axis=1).reshape(-1)
        body: Matrix = np.concatenate([h, context.mean[stage], attended, context.general])
        for name in ("body1", "body2", "body3"):
            body = self._silu(name, body)
        out = self._linear("answer", body).astype(np.float64).reshape(3, COMPONENTS)
        weight, mean, spread = out
        weight -= weight.max()
        np.exp(weight, out=weight)
        weight /= weight.sum()
        mean *= UNIT * MEAN_SCALE
        mean += CENTRE
        np.minimum(np.maximum(spread, SPREAD[0]), SPREAD[1], out=spread)
        np.exp(spread, out=spread)
        spread *= UNIT
        return out

    def _scaled(self, name: str, x: NDArray[Any]) -> Matrix:
        mean, sd = self._scales[name]
        scaled: Matrix = x.astype(np.float32)
        scaled -= mean
        scaled /= sd
        np.maximum(scaled, -FARTHEST, out=scaled)  # quicker than clip
        np.minimum(scaled, FARTHEST, out=scaled)
        return scaled

    def _linear(self, name: str, x: Matrix) -> Matrix:
        weight, bias = self._layers[name]
        out: Matrix = x @ weight.T
        out += bias
        return out

    def _silu(self, name: str, x: Matrix) -> Matrix:
        y = self._linear(name, x)
        # Only a lower bound is needed: far above 0 the exponential vanishes.
        e = np.maximum(y, _FAR_BELOW)
        np.negative(e, out=e)
        np.exp(e, out=e)
        e += 1
        y /= e
        return y


#: Bounds of ln(standard deviation / UNIT), and the scale of the means at the start of training.
SPREAD = (-4.0, 2.0)
MEAN_SCALE = 0.6


_FAR_BELOW = np.float32(-60)


def _single(array: NDArray[np.floating]) -> Matrix:
    return np.ascontiguousarray(array, dtype=np.float32)
