"""Network conditioned on a rig by a few pinches of objects of known Shore A, without training.

The network was trained once on thousands of random rigs (``firstcontact pretrain``). A summary of
the user's rig is one of its inputs, so users train nothing.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from firstcontact.chain import Image, build_image
from firstcontact.chain.image import LINES, ModelConstants, RigConstants
from firstcontact.chain.touch import predict_touches, rig_inputs
from firstcontact.core import Finger, InputError
from firstcontact.core.layout import FINGERTIP_RATE
from firstcontact.core.physics import is_same_rate
from firstcontact.core.weights import take_array
from firstcontact.models.context_network import ContextNetwork, Familiar
from firstcontact.models.predictions import Predictions
from firstcontact.models.rig import STEP, MotorPitch, Rig, RigRegression, RigSpeeds, ear
from firstcontact.models.touches import Touches
from firstcontact.models.window_model import Arrays, Values
from firstcontact.signal import samples_in

#: Lowest and highest level of a rig that a file may hold, V.
LOUD = 1e-9, 1e9


class InContextModel:
    """Pre-trained network with the rigs that it is conditioned on, by finger number."""

    #: Name of the runtime in model files.
    kind: ClassVar[str] = "network"

    def __init__(
        self,
        network: ContextNetwork,
        familiar: Familiar,
        factors: NDArray[np.float64],
        level: float,
        rigs: Mapping[int, Rig],
        mixed: NDArray[np.float64],
    ) -> None:
        for name, array in (("factors", factors), ("mixed", mixed)):
            if array.shape != (len(Rig.STAGES),) or not (array > 0).all():
                raise InputError(
                    f"the array '{name}' must hold {len(Rig.STAGES)} numbers above 0, the factors "
                    "of the intervals' widths"
                )
        if Rig.ANY not in rigs:
            raise InputError(
                "the model file lacks the arrays for fingers without own examples: adapt the model "
                "again"
            )
        self.rate = FINGERTIP_RATE
        self.level = level
        self.network, self.familiar, self.factors = network, familiar, factors
        #: Factors of the intervals of a prediction that is averaged with a regression.
        self.mixed = mixed
        self.rigs = dict(rigs)

    def constants(self) -> ModelConstants:
        """Return all constants with which the chain predicts."""
        network, familiar = self.network, self.familiar
        return ModelConstants(
            before=samples_in(Touches.BEFORE, self.rate),
            moments=Touches.moments(self.rate),
            stages=Rig.STAGES,
            factors=self.factors,
            limit=familiar.limit,
            familiar=familiar.mean,
            whitening=familiar.whitening,
            mean=network["inputs.mean"],
            sd=network["inputs.sd"],
            layers=network.layers,
            answer=network["answer.weight"],
            answer_bias=network["answer.bias"],
            pitch_step=STEP,
            rigs=[self._rig_constants(finger, rig) for finger, rig in self.rigs.items()],
            **ear(self.rate),
        )

    def _rig_constants(self, finger: int, rig: Rig) -> RigConstants:
        regression, speeds = self.regressions.get(finger), rig.speeds or RigSpeeds(0.0, 0.0)
        return RigConstants(
            finger=finger,
            has_level=rig.tokens.shape[1] > 0,
            level=rig.level,
            sign=rig.sign,
            terms=self.network.rig_term(rig.tokens, rig.general),
            reference=None if rig.pitch is None else rig.pitch.reference,
            usual_pitch=0.0 if rig.pitch is None else rig.pitch.usual,
            usual_speed=speeds.usual,
            speed_spread=speeds.spread,
            heard_error=speeds.heard_error if np.isfinite(speeds.heard_error) else 0.0,
            process=None if regression is None else regression.constants(),
        )

    @cached_property
    def image(self) -> Image:
        """Constants of the model, without a detector, as the chain reads them."""
        return build_image(self.rate, model=self.constants())

    @property
    def is_compiled(self) -> bool:
        """True if the chain in C predicts, False if a subclass does so in Python."""
        return type(self).predict is InContextModel.predict

    def half_widths(self, spreads: Values, samples: NDArray[np.intp] | int) -> Values:
        """Return the half widths of intervals for predictions from so many samples."""
        return spreads * self.factors[Rig.stage_index(samples)]

    @property
    def shortest(self) -> int:
        """Smallest number of valid samples for a prediction."""
        return Touches.lengths(self.rate)[0]

    def network_alone(self) -> InContextModel:
        """Return the model without a regression that refines the network's predictions."""
        return self

    def conditioned_on(self, rigs: Mapping[int, Rig]) -> InContextModel:
        """Return a model with the same network, conditioned on these rigs instead."""
        return InContextModel(
            self.network, self.familiar, self.factors, self.level, rigs, self.mixed
        )

    def widened(self, scales: NDArray[np.float64]) -> InContextModel:
        """Return the model with intervals widened by a factor for each stage, shape (stages,)."""
        factors = self.factors * scales
        return InContextModel(
            self.network, self.familiar, factors, self.level, self.rigs, self.mixed
        )

    def inputs(self, touches: Touches) -> NDArray[np.float32]:
        """Return the inputs of the network for these contacts, shape (n, INPUTS)."""
        self._check(touches)
        return rig_inputs(self.image, *touches.arrays)

    def predict(self, touches: Touches) -> Predictions:
        """Return a prediction for each contact, from its samples before the second contact."""
        self._check(touches)
        out = predict_touches(self.image, *touches.arrays)
        if not (is_finite := np.isfinite(out).all(axis=1)).all():
            raise InputError(
                f"the model predicts no finite number for contact {is_finite.argmin()}: leave the "
                "contact out, or make the model again"
            )
        value, low, high, _, spread, is_out_of_range = out.T
        elapsed = touches.valid / touches.rate
        return Predictions(value, spread, low, high, is_out_of_range > 0, elapsed)

    @property
    def regressions(self) -> Mapping[int, RigRegression]:
        """Regressions of rigs, with which the network's predictions are averaged, by finger."""
        return {}

    def _check(self, touches: Touches) -> None:
        if not is_same_rate(touches.rate, self.rate):
            raise InputError(
                f"the model needs signals at {self.rate:g} Hz, but these have {touches.rate:g} Hz: "
                "resample the pinches first"
            )
        if len(touches) and touches.valid.min() < self.shortest:
            raise InputError(
                f"a prediction needs {self.shortest} samples after the contact, but only "
                f"{touches.valid.min()} exist: wait for more"
            )

    def to_arrays(self) -> Arrays:
        """Return the network's arrays, and each rig's arrays as ``rig.FINGER.NAME``."""
        arrays = {**self.network.to_arrays(), **self.familiar.to_arrays()}
        arrays |= {"factors": self.factors, "mixed": self.mixed}
        for finger, rig in self.rigs.items():
            for name, array in _rig_arrays(rig).items():
                arrays[f"rig.{finger}.{name}"] = array
        return arrays

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]], level: float) -> Self:
        """Build the model from the arrays that :meth:`to_arrays` returned."""
        fingers = {_finger(name) for name in arrays if name.startswith("rig.")}
        rigs = {f: _rig(arrays, f"rig.{f}.") for f in fingers} or {Rig.ANY: Rig.unknown()}
        factors, mixed = (
            take_array(arrays, name, len(Rig.STAGES)).astype(np.float64)
            for name in ("factors", "mixed")
        )
        network, familiar = ContextNetwork(arrays), Familiar.from_arrays(arrays)
        made = cls(network, familiar, factors, level, rigs, mixed)
        made.image.handle  # noqa: B018 - refuse numbers that could overflow
        return made


def _rig_arrays(rig: Rig) -> Arrays:
    arrays: Arrays = {
        # A speed of 0 stands for an unknown speed.
        "scalars": np.array([rig.level, rig.sign, rig.speeds.usual if rig.speeds else 0.0]),
        "tokens": rig.tokens.astype(np.float32),
        "general": rig.general,
    }
    if rig.speeds is not None:  # files hold finite numbers only: 0 stands for an infinite error
        error = rig.speeds.heard_error
        arrays["speeds"] = np.array([rig.speeds.spread, error if np.isfinite(error) else 0.0])
    if rig.pitch is not None:
        arrays["reference"] = rig.pitch.reference
        arrays["usual"] = np.array([rig.pitch.usual])
    return arrays


def _finger(name: str) -> int:
    numbers: dict[str, int] = {str(finger): finger for finger in (Rig.ANY, *range(len(Finger)))}
    finger = numbers.get(name.split(".")[1])
    if finger is None:
        raise InputError(f"the array '{name}' has no finger's number in its name")
    return finger


def _rig(arrays: Mapping[str, NDArray[Any]], at: str) -> Rig:
    level, sign, speed = take_array(arrays, at + "scalars", 3).astype(np.float64).tolist()
    if not LOUD[0] <= level <= LOUD[1] or sign not in (1.0, -1.0) or speed < 0:
        raise InputError(
            f"the array '{at}scalars' holds an impossible loudness, sign or closing speed of a rig"
        )
    tokens = take_array(arrays, at + "tokens", len(Rig.STAGES), None, Rig.TOKEN).astype(np.float64)
    general = take_array(arrays, at + "general", Rig.GENERAL).astype(np.float64)
    pitch = None
    if at + "reference" in arrays:
        reference = take_array(arrays, at + "reference", LINES).astype(np.float32)
        pitch = MotorPitch(reference, float(take_array(arrays, at + "usual", 1)[0]))
    speeds = None
    if speed:
        spread, error = take_array(arrays, at + "speeds", 2).astype(np.float64).tolist()
        speeds = RigSpeeds(speed, spread, error or float("inf"))
        if not speeds.is_possible:
            raise InputError(f"the array '{at}speeds' holds an impossible spread or error")
    return Rig(level, sign, pitch, speeds, tokens, general)
