"""Pre-trained network, adapted to a rig by a few pinches of objects of known Shore A.

The network was trained once on thousands of random rigs (``firstcontact pretrain``). A summary of
the user's rig is one of its inputs, so users train nothing.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import replace
from functools import cached_property
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from firstcontact.chain import Image, build_image
from firstcontact.chain.constants import ModelConstants, RigConstants
from firstcontact.chain.image import LINES
from firstcontact.chain.touch import predict_touches, rig_inputs
from firstcontact.core import Contact, Dataset, Finger, ModelError
from firstcontact.core.layout import FINGERTIP_RATE
from firstcontact.core.physics import is_same_rate
from firstcontact.core.weights import take_array
from firstcontact.models.anytime import LONGEST, AnytimeModel, Hints, Prediction
from firstcontact.models.predictions import Predictions
from firstcontact.models.rig.context_network import ContextNetwork, Familiar
from firstcontact.models.rig.rigs import (
    STEP,
    MotorPitch,
    Rig,
    RigRegression,
    RigSpeeds,
    spectrum_constants,
)
from firstcontact.models.touches import Touches
from firstcontact.models.values import Arrays, Values
from firstcontact.signal import samples_in

#: Lowest and highest level of a rig that a file may hold, V.
LOUD = 1e-9, 1e9


class RigModel(AnytimeModel):
    """Pre-trained network with a summary of each rig that it is adapted to.

    A rig is the whole hand or one finger. Keys of ``rigs`` and ``regressions`` are finger numbers;
    -1 is the whole hand. A rig may also have a regression on its own pinches. Then a prediction is
    a mixture of the network's prediction and the regression's, weighted by the inverse of their
    variances. Its spread is the standard deviation of the mixture, so it grows where both differ.
    The regression dominates for contacts like those of the rig's pinches, the network for others.
    """

    kind: ClassVar[str] = "network"
    #: Name of models with regressions.
    COMBINED: ClassVar[str] = "combined"

    uses_shape = True
    level: float
    rate = FINGERTIP_RATE
    lengths = Touches.all_lengths(FINGERTIP_RATE)
    before = samples_in(Touches.BEFORE, FINGERTIP_RATE)
    prediction_times = Touches.TIMES
    #: Smallest number of valid samples for a prediction.
    shortest: ClassVar[int] = Touches.lengths(FINGERTIP_RATE)[0]

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
                raise ModelError(
                    f"the array '{name}' must hold {len(Rig.STAGES)} numbers above 0, the factors "
                    "of the intervals' widths"
                )
        if Rig.ANY not in rigs:
            raise ModelError(
                "the model file lacks the arrays for fingers without own examples: adapt the model "
                "again"
            )
        self.level = level
        self.network, self.familiar = network, familiar
        #: Factors of the intervals' widths: of all predictions, and of the network alone.
        self.factors = self.network_factors = factors
        #: Factors of the intervals of a prediction that is averaged with a regression.
        self.mixed = mixed
        self.rigs: Mapping[int, Rig] = dict(rigs)
        #: Regression of each rig, by finger number; empty if the network predicts alone.
        self.regressions: Mapping[int, RigRegression] = {}

    @property
    def name(self) -> str:
        return self.COMBINED if self.regressions else self.kind

    @property
    def uses_speed(self) -> bool:  # type: ignore[override]
        """True if measured speeds of the rig's own pinches are known.

        Otherwise speeds are ignored.
        """
        return any(rig.speeds is not None for rig in self.rigs.values())

    def chain_constants(self) -> ModelConstants:
        network, familiar = self.network, self.familiar
        return ModelConstants(
            before=self.before,
            moments=self.lengths,
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
            **spectrum_constants(self.rate),
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
            process=None if regression is None else regression.chain_constants(),
        )

    @cached_property
    def image(self) -> Image:
        """Constants of the model in the format of the C chain, without a contact detector."""
        return build_image(self.rate, model=self.chain_constants())

    def half_widths(self, spreads: Values, samples: NDArray[np.intp] | int) -> Values:
        """Return half widths of intervals from predicted standard deviations, Shore A, shape (n,).

        ``samples`` are the lengths of the signals after the contact.
        """
        return spreads * self.factors[Rig.stage_index(samples)]

    def network_alone(self) -> Self:
        """Return the network without regressions, with its own interval widths."""
        return self._changed(factors=self.network_factors, regressions={})

    def conditioned_on(self, rigs: Mapping[int, Rig]) -> Self:
        """Return the same network, adapted to other rigs and without regressions.

        Keys of ``rigs`` are finger numbers; -1 is the whole hand.
        """
        return self.network_alone()._changed(rigs=dict(rigs))

    def with_regressions(
        self, regressions: Mapping[int, RigRegression], factors: NDArray[np.float64]
    ) -> Self:
        """Return a model that averages this network with the regression of each rig.

        Keys of ``regressions`` are finger numbers. ``factors`` turn standard deviations of the
        average into half widths of intervals, shape (signal lengths,).
        """
        return self._changed(regressions=dict(regressions), factors=factors)

    def rescaled(self, scales: NDArray[np.float64]) -> Self:
        """Return the model with the intervals of each signal length scaled by a factor.

        ``scales`` holds these factors, shape (signal lengths,).
        """
        factors = self.factors * scales
        alone = self.network_factors if self.regressions else factors
        return self._changed(factors=factors, network_factors=alone)

    def _changed(self, **attributes: Any) -> Self:
        other = copy(self)
        other.__dict__.pop("image", None)  # it is made again when it is needed
        other.__dict__.update(attributes)
        return other

    def inputs(self, touches: Touches) -> NDArray[np.float32]:
        """Return the inputs of the network for these contacts, shape (n, INPUTS)."""
        self._check(touches)
        return rig_inputs(self.image, *touches.arrays)

    def predict(
        self, signal: NDArray[np.float64], samples: int, finger: int, hints: Hints
    ) -> Prediction | None:
        cut = Touches.cut_signal(signal, len(signal) - samples, self.rate)
        if cut is None:
            return None
        speed, error, radius = (np.array([hint]) for hint in hints)
        speed[speed == 0.0] = np.nan
        one = Touches(
            cut[None], np.array([samples]), np.array([finger]), speed, error, radius, self.rate
        )
        p = self.predict_touches(one)
        half_width = self.half_widths(p.spread, one.valid)
        arrays = p.value, p.low, p.high, half_width, p.spread
        value, low, high, half, spread = (float(array[0]) for array in arrays)
        return Prediction(value, low, high, half, spread, bool(p.out_of_range[0]))

    def predict_pinches(
        self, data: Dataset, contacts: Sequence[Contact | None], at: float = LONGEST
    ) -> Predictions:
        out = Predictions.empty(contacts)
        touches, rows = Touches.cut(data, contacts)
        samples = self.usable_lengths(data, contacts, at)[rows]
        touches = replace(touches, valid=samples)
        touches, rows = touches.take(samples > 0), rows[samples > 0]
        if len(rows):
            out.put(rows, self.predict_touches(touches))
        return out

    def predict_touches(self, touches: Touches) -> Predictions:
        """Return one prediction per contact, from the samples before the second finger's contact.

        Raise ModelError for contacts at another rate, or with too few samples.
        """
        self._check(touches)
        out = predict_touches(self.image, *touches.arrays)
        if not (is_finite := np.isfinite(out).all(axis=1)).all():
            raise ModelError(
                f"the model predicts no finite number for contact {is_finite.argmin()}: leave the "
                "contact out, or make the model again"
            )
        value, low, high, _, spread, is_out_of_range = out.T
        elapsed = touches.valid / touches.rate
        return Predictions(value, spread, low, high, is_out_of_range > 0, elapsed)

    def regress(self, touches: Touches) -> tuple[Values, Values]:
        """Return the regressions' predictions and standard deviations, Shore A, shape (n,) each."""
        out = predict_touches(self.image, *touches.arrays, is_regression=True)
        return out[:, 0], out[:, 4]

    def _check(self, touches: Touches) -> None:
        if not is_same_rate(touches.rate, self.rate):
            raise ModelError(
                f"the model needs signals at {self.rate:g} Hz, but these have {touches.rate:g} Hz: "
                "resample the pinches first"
            )
        if len(touches) and touches.valid.min() < self.shortest:
            raise ModelError(
                f"a prediction needs {self.shortest} samples after the contact, but only "
                f"{touches.valid.min()} exist: wait for more"
            )

    def to_arrays(self) -> Arrays:
        """Return all arrays of the model by name: weights, summaries of rigs, and regressions.

        Names of a rig's summary begin with ``rig.FINGER.``, those of its regression with
        ``own.FINGER.``.
        """
        arrays = {**self.network.to_arrays(), **self.familiar.to_arrays()}
        arrays |= {"factors": self.factors, "mixed": self.mixed}
        for finger, rig in self.rigs.items():
            for name, array in _rig_arrays(rig).items():
                arrays[f"rig.{finger}.{name}"] = array
        if self.regressions:
            arrays["own.factors"] = self.network_factors
        for finger, regression in self.regressions.items():
            for name, array in regression.to_arrays().items():
                arrays[f"own.{finger}.{name}"] = array
        return arrays

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]], level: float | None) -> Self:
        fingers = {_finger(name) for name in arrays if name.startswith("rig.")}
        rigs = {f: _rig(arrays, f"rig.{f}.") for f in fingers} or {Rig.ANY: Rig.unknown()}
        factors, mixed = (
            take_array(arrays, name, len(Rig.STAGES)).astype(np.float64)
            for name in ("factors", "mixed")
        )
        if level is None:
            raise ModelError("the model file states no level of its intervals")
        network, familiar = ContextNetwork(arrays), Familiar.from_arrays(arrays)
        made = cls(network, familiar, factors, level, rigs, mixed)
        if "own.factors" in arrays:
            own = take_array(arrays, "own.factors", len(Rig.STAGES))
            made.network_factors = own.astype(np.float64)
            made.regressions = {f: RigRegression.from_arrays(arrays, f"own.{f}.") for f in rigs}
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
        raise ModelError(f"the array '{name}' has no finger's number in its name")
    return finger


def _rig(arrays: Mapping[str, NDArray[Any]], prefix: str) -> Rig:
    level, sign, speed = take_array(arrays, prefix + "scalars", 3).astype(np.float64).tolist()
    if not LOUD[0] <= level <= LOUD[1] or sign not in (1.0, -1.0) or speed < 0:
        raise ModelError(
            f"the array '{prefix}scalars' holds an impossible loudness, sign or speed of a rig"
        )
    tokens = take_array(arrays, prefix + "tokens", len(Rig.STAGES), None, Rig.TOKEN).astype(
        np.float64
    )
    general = take_array(arrays, prefix + "general", Rig.GENERAL).astype(np.float64)
    pitch = None
    if prefix + "reference" in arrays:
        reference = take_array(arrays, prefix + "reference", LINES).astype(np.float32)
        pitch = MotorPitch(reference, float(take_array(arrays, prefix + "usual", 1)[0]))
    speeds = None
    if speed:
        spread, error = take_array(arrays, prefix + "speeds", 2).astype(np.float64).tolist()
        speeds = RigSpeeds(speed, spread, error or float("inf"))
        if not speeds.is_possible:
            raise ModelError(f"the array '{prefix}speeds' holds an impossible spread or error")
    return Rig(level, sign, pitch, speeds, tokens, general)
