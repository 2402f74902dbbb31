"""Network conditioned on a rig by a few pinches of objects of known Shore A, without training.

The network was trained once on thousands of random rigs (``firstcontact pretrain``). A summary of
the user's rig is one of its inputs, so users train nothing.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import (
    FINGERTIP_RATE,
    Finger,
    InputError,
    is_same_rate,
    parse_int,
    take_array,
)
from firstcontact.models._contact_features import Shape
from firstcontact.models._context_network import Context, Network
from firstcontact.models._interval import SHORE_A
from firstcontact.models._motor_pitch import POINTS, MotorPitch
from firstcontact.models._network_inputs import BESIDE, beside, network_inputs
from firstcontact.models._out_of_range import Familiar, shape_traits
from firstcontact.models._predictions import Predictions
from firstcontact.models._rig import GENERAL, STAGES, TOKEN, Rig, stage_index
from firstcontact.models._rig_regression import RigRegression
from firstcontact.models._rig_speeds import LEAST, MOST, RigSpeeds
from firstcontact.models._single_contact import SingleContactPredictor
from firstcontact.models._spec import Arrays, Values
from firstcontact.models._touches import Touches, lengths

#: Finger number of the rig that holds for any finger.
ANY = -1
#: Lowest and highest level of a rig that a file may hold, V.
LOUD = 1e-9, 1e9


class InContextModel:
    """Pre-trained network with the rigs that it is conditioned on.

    Parameters
    ----------
    network, familiar
        Pre-trained network, and statistics of its training contacts.
    factors
        Half width of the interval at each time of ``STAGES``, as a multiple of the model's own
        spread, shape (stages,).
    level
        Nominal share of truths inside the intervals.
    rigs
        Rigs by finger number. The entry ``ANY`` applies to all other fingers.

    Raises
    ------
    InputError
        Arrays do not fit together.
    """

    #: Name of the runtime in model files.
    kind: ClassVar[str] = "network"
    #: True if :meth:`refine` changes predictions.
    refines: ClassVar[bool] = False

    def __init__(
        self,
        network: Network,
        familiar: Familiar,
        factors: NDArray[np.float64],
        level: float,
        rigs: Mapping[int, Rig],
    ) -> None:
        if factors.shape != (len(STAGES),) or not (factors > 0).all():
            raise InputError(
                f"the array 'factors' must hold {len(STAGES)} numbers above 0, the factors of the "
                "intervals' widths"
            )
        if ANY not in rigs:
            raise InputError("the arrays of the rig for all fingers are missing: train again")
        self.rate = FINGERTIP_RATE
        self.level = level
        self._network, self._familiar, self._factors = network, familiar, factors
        self.rigs = dict(rigs)
        self._contexts: dict[int, Context] = {
            finger: network.context(rig.tokens, rig.general) for finger, rig in rigs.items()
        }

    def follow(self, touches: Touches) -> SingleContactPredictor:
        """Return a predictor for one contact, which uses the signal as it arrives.

        ``touches`` holds only this contact.
        """
        self._check(touches)
        rig = self.rigs[self.by_rig(touches)[0][0]]
        return SingleContactPredictor(self, touches, beside(touches, rig, one=True))

    @property
    def network(self) -> Network:
        """The pre-trained network."""
        return self._network

    @property
    def familiar(self) -> Familiar:
        """Statistics of the network's training contacts."""
        return self._familiar

    @property
    def factors(self) -> NDArray[np.float64]:
        """Half widths of the intervals at the times ``STAGES``, in spreads, shape (stages,)."""
        return self._factors

    def context(self, finger: int) -> Context:
        """Return the network's encoding of the rig that has this finger number."""
        return self._contexts[finger]

    def half_widths(
        self, spreads: Values, samples: NDArray[np.intp] | int, rate: float = FINGERTIP_RATE
    ) -> Values:
        """Return the half widths of intervals for predictions with these spreads.

        ``samples`` is the number of samples after the contact that each prediction used.
        """
        return spreads * self._factors[stage_index(samples, rate)]

    @property
    def shortest(self) -> int:
        """Smallest number of valid samples for a prediction."""
        return lengths(self.rate)[0]

    def network_alone(self) -> InContextModel:
        """Return the model without a regression that refines the network's predictions."""
        return self

    def conditioned_on(self, rigs: Mapping[int, Rig]) -> InContextModel:
        """Return a model with the same network, conditioned on these rigs instead."""
        return InContextModel(self._network, self._familiar, self._factors, self.level, rigs)

    def widened(self, scales: NDArray[np.float64]) -> InContextModel:
        """Return the model with intervals widened by a factor for each stage, shape (stages,)."""
        factors = self._factors * scales
        return InContextModel(self._network, self._familiar, factors, self.level, self.rigs)

    def rig_features(self, touches: Touches) -> NDArray[np.float64]:
        """Return the inputs of the network that do not depend on the signal after the contacts."""
        out = np.empty((len(touches), BESIDE))
        for finger, rows in self.by_rig(touches):
            out[rows] = beside(touches.take(rows), self.rigs[finger])
        return out

    def predict(
        self, touches: Touches, rig_features: NDArray[np.float64] | None = None
    ) -> Predictions:
        """Return a prediction for each contact, from its samples before the second contact.

        Parameters
        ----------
        touches
            Contacts.
        rig_features
            Result of :meth:`rig_features`, if computed already.

        Raises
        ------
        InputError
            The contacts have another sampling rate, or fewer valid samples than a prediction needs.
        """
        self._check(touches)
        n = len(touches)
        values, spreads = np.empty(n), np.empty(n)
        out_of_range = np.zeros(n, np.bool_)
        beside_signal = self.rig_features(touches) if rig_features is None else rig_features
        stages = stage_index(touches.valid, touches.rate)
        for finger, rows in self.by_rig(touches):
            rig = self.rigs[finger]
            part = touches if len(rows) == n else touches.take(rows)
            level, sign = np.full(len(part), rig.level), np.full(len(part), rig.sign)
            shape = Shape.measure(part.waves, part.valid, level, sign)
            x = network_inputs(shape, beside_signal[rows])
            mixture = self._network.outputs(x, self._contexts[finger], stages[rows])
            predictions = np.stack(mean_and_spread(mixture), axis=1)
            if self.refines:
                given = zip(x, stages[rows].tolist(), predictions.tolist(), strict=True)
                predictions = np.array([self.refine(finger, x, stage, *p) for x, stage, p in given])
            values[rows], spreads[rows] = predictions.T
            trait_values = shape_traits(shape, part.signals[:, : part.lead])
            has_level = rig.tokens.shape[1] > 0
            out_of_range[rows] = self._familiar.out_of_range(trait_values, stages[rows], has_level)
        wrong = np.flatnonzero(~np.isfinite(values + spreads))
        if len(wrong):
            raise InputError(
                f"the model predicts no finite number for contact {wrong[0]}: leave the contact "
                "out, or make the model again"
            )
        half = self.half_widths(spreads, touches.valid, touches.rate)
        values = np.clip(values, *SHORE_A)
        low, high = (np.clip(values + side * half, *SHORE_A) for side in (-1, 1))
        elapsed = touches.valid / touches.rate
        return Predictions(values, spreads, low, high, out_of_range, elapsed)

    def refine(
        self,
        finger: int,
        x: NDArray[np.float64],
        stage: int,
        value: float,
        spread: float,
    ) -> tuple[float, float]:
        """Return the network's prediction for one contact. Subclasses refine it.

        Parameters
        ----------
        finger
            Number of the rig.
        x
            Inputs of the network, shape (inputs,).
        stage
            Position in ``STAGES``.
        value, spread
            Prediction and spread of the network.
        """
        return value, spread

    def regression(self, finger: int) -> RigRegression | None:
        """Return the regression that :meth:`refine` mixes with the network; None without one."""
        return None

    def _check(self, touches: Touches) -> None:
        if not is_same_rate(touches.rate, self.rate):
            raise InputError(
                f"the model takes contacts at {self.rate:g} Hz but these have {touches.rate:g} Hz: "
                "resample the pinches first"
            )
        if len(touches) and touches.valid.min() < self.shortest:
            raise InputError(
                f"a prediction needs {self.shortest} samples after the contact, but only "
                f"{touches.valid.min()} exist: wait for more"
            )

    def by_rig(self, touches: Touches) -> list[tuple[int, NDArray[np.intp]]]:
        """Return each rig's finger number, with the positions of the rig's contacts."""
        numbers = [f if f in self.rigs else ANY for f in touches.fingers.tolist()]
        if len(set(numbers)) == 1:
            return [(numbers[0], np.arange(len(numbers)))]
        finger = np.array(numbers, np.intp)
        return [(f, np.flatnonzero(finger == f)) for f in sorted(set(numbers))]

    @classmethod
    def restore_network(cls, arrays: Mapping[str, NDArray[Any]]) -> Network:
        """Return the network that a file's arrays describe."""
        return Network(arrays)

    def to_arrays(self) -> Arrays:
        """Return the network's arrays, and each rig's arrays as ``rig.FINGER.NAME``."""
        arrays = {**self._network.to_arrays(), **self._familiar.to_arrays()}
        arrays["factors"] = self._factors
        for finger, rig in self.rigs.items():
            for name, array in _rig_arrays(rig).items():
                arrays[f"rig.{finger}.{name}"] = array
        return arrays

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]], level: float) -> Self:
        """Build the model from the arrays that :meth:`to_arrays` returned.

        Raises
        ------
        InputError
            Arrays are missing or do not fit together.
        """
        fingers = {_finger(name) for name in arrays if name.startswith("rig.")}
        rigs = {f: _rig(arrays, f"rig.{f}.") for f in fingers} or {ANY: Rig.unknown()}
        factors = take_array(arrays, "factors", len(STAGES)).astype(np.float64)
        return cls(cls.restore_network(arrays), Familiar.from_arrays(arrays), factors, level, rigs)


def mean_and_spread(mixture: NDArray[np.float64]) -> tuple[Values, Values]:
    """Return mean and standard deviation of mixtures from :meth:`Network.outputs`."""
    weight, mean, sd = mixture
    value: Values = (weight * mean).sum(axis=1)
    square = (weight * (sd * sd + mean * mean)).sum(axis=1)
    return value, np.sqrt(np.maximum(square - value * value, 1e-4))


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
    try:
        finger = parse_int(name.split(".")[1])
    except ValueError:
        raise InputError(f"the array '{name}' has no finger's number in its name") from None
    if finger not in (ANY, *range(len(Finger))):
        raise InputError(f"the array '{name}' has the number of an unknown finger in its name")
    return finger


def _rig(arrays: Mapping[str, NDArray[Any]], at: str) -> Rig:
    level, sign, speed = take_array(arrays, at + "scalars", 3).astype(np.float64).tolist()
    if not LOUD[0] <= level <= LOUD[1] or sign not in (1.0, -1.0) or speed < 0:
        raise InputError(
            f"the array '{at}scalars' holds an impossible loudness, sign or closing speed of a rig"
        )
    tokens = take_array(arrays, at + "tokens", len(STAGES), None, TOKEN).astype(np.float64)
    general = take_array(arrays, at + "general", GENERAL).astype(np.float64)
    pitch = None
    if at + "reference" in arrays:
        reference = take_array(arrays, at + "reference", POINTS).astype(np.float64)
        pitch = MotorPitch(reference, float(take_array(arrays, at + "usual", 1)[0]))
    speeds = _declared_speeds(arrays, at, speed) if speed else None
    return Rig(level, sign, pitch, speeds, tokens, general)


def _declared_speeds(arrays: Mapping[str, NDArray[Any]], at: str, usual: float) -> RigSpeeds:
    if at + "speeds" not in arrays:  # of a version that took each speed as exact
        return RigSpeeds(usual)
    spread, error = take_array(arrays, at + "speeds", 2).astype(np.float64).tolist()
    if not LEAST <= spread <= MOST or (error and not LEAST <= error <= MOST):
        raise InputError(
            f"the array '{at}speeds' holds an impossible spread or standard error of closing speeds"
        )
    return RigSpeeds(usual, spread, error or float("inf"))
