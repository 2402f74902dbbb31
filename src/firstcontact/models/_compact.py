"""Compact network for a small processor: low-rank layers with integer weights.

For the contacts of one rig, the outputs of a layer vary along a few directions only. Let P hold the
first of these directions, and m the mean output. Then ``y = W x + b`` is close to ``m + P (P' (W x
+ b - m))``: two thin layers. Their weights are rounded to integers whose sums cannot overflow 32
bits. This network in NumPy predicts the same as its C export.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import InputError, take_array
from firstcontact.models._context_network import Context, Matrix, Network
from firstcontact.models._in_context import InContextModel
from firstcontact.models._network_inputs import rig_inputs
from firstcontact.models._rig import GENERAL, stage_index
from firstcontact.models._touches import Touches, lengths

#: Layers that are replaced by thin ones. The other layers have few weights, or are computed once
#: for a rig.
THIN = ("query1", "query2", "body1", "body2", "body3")
#: Limit on the sum of a row's integer magnitudes, so that it stays below 2^31 after multiplication
#: by 2^15.
MOST = 65_000
#: Smallest number of contacts from which directions are computed.
FEWEST = 40


@dataclass(frozen=True, slots=True, eq=False)
class Rounded:
    """Layer whose weights are integers times a scale for each row.

    Parameters
    ----------
    integers
        Weights as int16, shape (outputs, inputs).
    scale, bias
        Scale and bias of each row, shape (outputs,).
    """

    integers: NDArray[np.int16]
    scale: NDArray[np.float32]
    bias: NDArray[np.float32]

    @classmethod
    def nearest(cls, weight: NDArray[np.floating], bias: NDArray[np.floating]) -> Rounded:
        """Return a layer with its weights rounded to integers."""
        most = np.maximum(np.abs(weight).sum(axis=1) / MOST, np.abs(weight).max(axis=1) / 32_000)
        scale = np.maximum(most, 1e-30).astype(np.float32)
        integers = np.rint(weight / scale[:, None]).astype(np.int16)
        return cls(integers, scale, bias.astype(np.float32))

    def __call__(self, x: Matrix) -> Matrix:
        """Return outputs for inputs (..., inputs), after rounding each row of inputs to 15 bits."""
        most = np.abs(x).max(axis=-1, keepdims=True)
        each = np.where(most > 1e-30, np.float32(32767) / np.maximum(most, 1e-30), np.float32(0))
        steps = x * each.astype(np.float32)
        rounded = np.trunc(steps + np.copysign(np.float32(0.5), steps)).astype(np.float64)
        sums = (rounded @ self.integers.T.astype(np.float64)).astype(np.float32)  # exact until here
        outputs: Matrix = sums * (self.scale * (most / np.float32(32767))) + self.bias
        return outputs

    def most(self, most: float) -> float:
        """Return the largest possible output for inputs whose magnitude is at most ``most``."""
        sums = np.maximum(np.abs(self.integers.astype(np.float64)).sum(axis=1), 1.0)
        scale, bias = (np.abs(x.astype(np.float64)) for x in (self.scale, self.bias))
        return float((sums * scale * most + bias).max(initial=0.0))


@dataclass(frozen=True, slots=True, eq=False)
class Thin:
    """Two thin layers that replace one layer.

    Parameters
    ----------
    into
        Layer from the inputs to the directions. For the network's layer ``body1`` it has only the
        inputs that change with the contact; ``fixed`` holds the weights of the other inputs.
    out
        Layer from the directions to the outputs.
    fixed
        Weights of the inputs that do not change with the contact, float32, shape (directions, fixed
        inputs).
    """

    into: Rounded
    out: Rounded
    fixed: Matrix


class CompactNetwork(Network):
    """Network whose large layers are each replaced by two thin layers.

    Parameters
    ----------
    base
        Pre-trained network.
    layers
        Thin layers by name, one for each name in ``THIN``.
    """

    def __init__(self, base: Network, layers: Mapping[str, Thin]) -> None:
        self.thin = dict(layers)
        super().__init__(base.to_arrays())
        self._hidden = len(self._layers["query1"][1])
        self._rest = self._layers["mean"][0].shape[0]

    def _linear(self, name: str, x: Matrix) -> Matrix:
        thin = self.thin.get(name)
        if thin is None:
            return super()._linear(name, x)
        moving, fixed = self._parted(name, x)
        return thin.out(thin.into(moving) + fixed @ thin.fixed.T)

    def _parted(self, name: str, x: Matrix) -> tuple[Matrix, Matrix]:
        """Split the inputs of a layer into inputs that change with a contact, and fixed inputs."""
        is_moving = moving(name, x.shape[-1], self._hidden, self._rest)
        return x[..., is_moving], x[..., ~is_moving]

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Return the arrays of the network and ``thin.LAYER.PART`` of each thin layer."""
        arrays = super().to_arrays()
        for name, layer in self.thin.items():
            for part, rounded in (("into", layer.into), ("out", layer.out)):
                # Files store all weights as floats, which hold these integers exactly.
                arrays[f"thin.{name}.{part}.weight"] = rounded.integers.astype(np.float32)
                arrays[f"thin.{name}.{part}.scale"] = rounded.scale
                arrays[f"thin.{name}.{part}.bias"] = rounded.bias
            arrays[f"thin.{name}.rest"] = layer.fixed
        return arrays

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Self:
        """Restore from arrays of :meth:`to_arrays`; InputError if they do not fit together."""
        made = cls(Network(arrays), {})
        made.thin = {name: made._thin_layer(name, arrays) for name in THIN}
        made.check_reach()
        return made

    def _thin_layer(self, name: str, arrays: Mapping[str, NDArray[Any]]) -> Thin:
        weight, bias = self._layers[name]
        is_moving = moving(name, weight.shape[1], self._hidden, self._rest)
        into = _rounded(arrays, f"thin.{name}.into", None, int(is_moving.sum()))
        out = _rounded(arrays, f"thin.{name}.out", len(bias), len(into.bias))
        rest_weights = take_array(
            arrays, f"thin.{name}.rest", len(into.bias), int((~is_moving).sum())
        )
        return Thin(into, out, rest_weights.astype(np.float32))

    def _most(self, name: str, most: float) -> float:
        thin = self.thin.get(name)
        if thin is None:
            return super()._most(name, most)
        rest_reach = np.abs(thin.fixed.astype(np.float64)).sum(axis=1).max(initial=0.0) * most
        along = thin.into.most(most) + float(rest_reach)
        return max(along, thin.out.most(along))

    @property
    def answer(self) -> tuple[Matrix, Matrix]:
        """Weight and bias of the last layer, unrounded: rounding them would change predictions."""
        return self._layers["answer"]

    def along(self, context: Context, stage: int) -> Matrix:
        """Return the rig's contribution to the layer ``body1`` at a stage, shape (directions,)."""
        thin = self.thin["body1"]
        rig_inputs = np.concatenate([context.mean[stage], context.general])
        term: Matrix = thin.fixed @ rig_inputs + thin.into.bias
        return term


def _rounded(
    arrays: Mapping[str, NDArray[Any]], at: str, outputs: int | None, inputs: int
) -> Rounded:
    weight = take_array(arrays, f"{at}.weight", outputs, inputs).astype(np.float64)
    scale, bias = (take_array(arrays, f"{at}.{part}", len(weight)) for part in ("scale", "bias"))
    if (
        (weight != np.rint(weight)).any()
        or (np.abs(weight) > 32_767).any()
        or (np.abs(weight).sum(axis=1) > 65_535).any()
    ):
        raise InputError(f"the array '{at}.weight' holds values that are not 16-bit integers")
    return Rounded(weight.astype(np.int16), scale.astype(np.float32), bias.astype(np.float32))


class CompactModel(InContextModel):
    """Network in its compact form, which runs on the hand."""

    kind: ClassVar[str] = "compact"

    @classmethod
    def restore_network(cls, arrays: Mapping[str, NDArray[Any]]) -> Network:
        """Return the compact network from a file's arrays."""
        return CompactNetwork.from_arrays(arrays)


def moving(name: str, inputs: int, hidden: int, mean: int) -> NDArray[np.bool_]:
    """Return a mask of the inputs of a layer that change with a contact, shape (inputs,)."""
    is_moving = np.ones(inputs, np.bool_)
    if name == "body1":
        is_moving[hidden : hidden + mean] = False
        is_moving[-GENERAL:] = False
    return is_moving


class _Listening(Network):
    """Network that stores the outputs of its layers."""

    def __init__(self, base: Network) -> None:
        super().__init__(base.to_arrays())
        self.heard: dict[str, list[Matrix]] = {name: [] for name in THIN}

    def _linear(self, name: str, x: Matrix) -> Matrix:
        out = super()._linear(name, x)
        if name in self.heard:
            self.heard[name].append(out.copy())
        return out


def deaf(model: InContextModel) -> InContextModel:
    """Return a model that does not use the motor's pitch. It needs no spectrum before a contact."""
    return _told_nothing(model, False)


def _told_nothing(model: InContextModel, listening: bool) -> InContextModel:
    """Return a model that knows no measured speeds, and the pitch only if ``listening``."""
    rigs = {
        finger: replace(rig, pitch=rig.pitch if listening else None, speeds=None)
        for finger, rig in model.rigs.items()
    }
    return model.conditioned_on(rigs)


def compacted(
    model: InContextModel, touches: Touches, directions: int, listening: bool = False
) -> CompactModel:
    """Return a copy of a model with a compact network, and without measured closing speeds.

    Parameters
    ----------
    model
        Model of the rig.
    touches
        Contacts of the rig, from which the directions are computed.
    directions
        Number of directions of each thin layer.
    listening
        True to keep the motor's pitch as an input.

    Raises
    ------
    InputError
        There are too few contacts.
    """
    if len(touches) < FEWEST:
        raise InputError(
            f"{len(touches)} contacts are too few for the compact network: give {FEWEST} training "
            "pinches or more"
        )
    model = _told_nothing(model, listening)
    ears = _Listening(model.network)
    first, last = lengths(touches.rate)
    for samples in np.linspace(first, last, 7).round().astype(np.intp):
        _ask(ears, model, touches.until(int(samples)))
    arrays = model.network.to_arrays()
    hidden, mean = len(arrays["query1.bias"]), len(arrays["mean.bias"])
    layers = {}
    for name in THIN:
        weight, bias = arrays[f"{name}.weight"], arrays[f"{name}.bias"]
        is_moving = moving(name, weight.shape[1], hidden, mean)
        layers[name] = _thin(weight, bias, np.concatenate(ears.heard[name]), is_moving, directions)
    network = CompactNetwork(model.network, layers)
    return CompactModel(network, model.familiar, model.factors, model.level, model.rigs)


def _ask(network: Network, model: InContextModel, touches: Touches) -> None:
    """Run a network on the inputs that a model makes from contacts. Discard the outputs."""
    usable = touches.take(touches.valid >= model.shortest)
    for finger, rows in model.by_rig(usable):
        rig, part = model.rigs[finger], usable.take(rows)
        x = rig_inputs(part, rig, model.rig_features(part))
        stages = stage_index(part.valid, part.rate)
        network.outputs(x, network.context(rig.tokens, rig.general), stages)


def _thin(
    weight: Matrix, bias: Matrix, heard: Matrix, is_moving: NDArray[np.bool_], directions: int
) -> Thin:
    mean = heard.mean(axis=0, dtype=np.float64)
    away = heard - mean
    _, axes = np.linalg.eigh(away.T @ away)
    p = axes[:, : -1 - min(directions, len(bias)) : -1]
    into = p.T @ weight
    return Thin(
        Rounded.nearest(into[:, is_moving], p.T @ (bias - mean)),
        Rounded.nearest(p, mean),
        into[:, ~is_moving].astype(np.float32),
    )
