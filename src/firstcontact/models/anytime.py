"""Base classes of all models that predict stiffness after a contact."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from copy import copy
from dataclasses import replace
from math import nan
from typing import ClassVar, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from firstcontact.chain.constants import Constants, WindowConstants
from firstcontact.chain.image import SVMS_MOST
from firstcontact.core import ChannelKind, Contact, Dataset, Layout, ModelError, Pinch
from firstcontact.core.physics import is_same_rate, parse_radius
from firstcontact.core.quantity import SHORE_A, Quantity
from firstcontact.models.card import AnytimeCard, TrainingRecord, WindowCard
from firstcontact.models.predictions import Predictions
from firstcontact.models.touches import finger_number, speed_inputs, valid_samples
from firstcontact.models.values import Arrays
from firstcontact.signal import DeviceSmoothing, samples_in

#: Longest signal that a prediction may use, s.
LONGEST = 10.0


class Hints(NamedTuple):
    """Closing speed and object radius at a contact, which predictors may use besides the signal."""

    speed: float = 0.0
    error: float = 0.0
    radius: float = nan


class Prediction(NamedTuple):
    """Stiffness that a model predicts for one contact.

    Parameters
    ----------
    value, low, high
        Prediction and ends of its interval, in the unit of the predictor's quantity, or a class.
        Without an interval, both ends equal the value.
    half_width
        Half width of the interval before it was clipped to the scale; NaN if predictions for
        several pinches of an object must not be averaged.
    spread
        Standard deviation of the prediction; NaN if the model predicts none.
    out_of_range
        True if the contact is unlike the training data.
    """

    value: float
    low: float
    high: float
    half_width: float = nan
    spread: float = nan
    out_of_range: bool = False


class Predictor(ABC):
    """Predictor of stiffness at one or several times after a contact.

    Recordings, live sessions and exports use the same object.
    """

    #: Sampling rate of the signals, Hz.
    rate: float
    #: Numbers of samples after a contact with which the model predicts, ascending.
    lengths: Sequence[int]
    #: Largest number of samples before a contact that the model uses.
    before: int
    #: Number of samples after a moment that the predictor's filter needs.
    lookahead: int = 0
    #: True if a measured closing speed, or the shape of the object, is an input.
    uses_speed: bool = False
    uses_shape: bool = False
    #: Quantity that is predicted.
    quantity: Quantity = SHORE_A
    #: Classes that are predicted; empty for a regression.
    classes: tuple[float, ...] = ()
    #: Nominal coverage of the prediction intervals, such as 0.9; None without intervals.
    level: float | None = None
    #: Description of the training.
    record: TrainingRecord = TrainingRecord()

    @property
    @abstractmethod
    def name(self) -> str:
        """Name of the estimator that made the predictor, such as "svm"."""

    @property
    def prediction_times(self) -> tuple[float, ...]:
        """Times after a contact at which the predictor predicts, s, ascending."""
        return tuple(n / self.rate for n in self.lengths)

    @abstractmethod
    def predict(
        self, signal: NDArray[np.float64], samples: int, finger: int, hints: Hints
    ) -> Prediction | None:
        """Predict from the signal of one contact.

        Parameters
        ----------
        signal
            Vibration in V as the device sends it: at most ``before`` samples before the contact,
            and ``samples + lookahead`` from the contact on.
        samples
            Number of samples after the contact that the prediction may use, one of ``lengths``.
        finger
            Finger that touched: 0 is the index finger, 1 the thumb, -1 unknown.
        hints
            Closing speed and object's radius, if known.

        Returns
        -------
        Prediction or None
            None if the signal is unusable, for example constant or too short before the contact.
        """

    def chain_constants(self) -> Constants:
        """Return the constants that the C chain (:mod:`firstcontact.chain`) needs for predictions.

        The base class returns signal lengths only. The chain then calls :meth:`predict` in Python.
        """
        return WindowConstants(self.before, self.lengths, self.lookahead)

    def check(self, layout: Layout) -> None:
        """Raise InputError if samples with this layout cannot be used."""
        if not is_same_rate(layout.rate, self.rate):
            raise ModelError(
                f"{self.name} needs samples at {self.rate:g} Hz, but these have {layout.rate:g} "
                "Hz: resample them, or use a model for their rate"
            )

    def predict_pinches(
        self, data: Dataset, contacts: Sequence[Contact | None], at: float = LONGEST
    ) -> Predictions:
        """Predict the stiffness of each pinch from the signal after its first contact.

        ``contacts`` holds the first contact of each pinch, None without one. ``at`` is the longest
        signal after the contact to use, s. A prediction uses the longest of :attr:`lengths` that
        fits into ``at`` and, with the look-ahead, ends before the second finger's contact. If none
        fits, the prediction is NaN.
        """
        out = Predictions.empty(contacts)
        for row, samples in enumerate(self.usable_lengths(data, contacts, at).tolist()):
            pinch, contact = data.pinches[row], contacts[row]
            signal = None
            if contact is not None and samples:
                signal = contact_signal(pinch, contact, self.before, samples + self.lookahead)
            if contact is None or signal is None:
                continue
            speed, error = np.nan_to_num(speed_inputs(pinch.closing_speed)).tolist()
            hints = Hints(speed, error, parse_radius(pinch.label.shape))
            made = self.predict(signal, samples, finger_number(contact.finger), hints)
            if made is not None:
                out.put_one(row, made, samples / self.rate)
        return out

    def usable_lengths(
        self, data: Dataset, contacts: Sequence[Contact | None], at: float
    ) -> NDArray[np.intp]:
        """Return the number of samples after each contact that a prediction uses, shape (pinches,).

        It is one of :attr:`lengths`, at most ``at`` (s) long, or 0 if there is no prediction.
        """
        available = valid_samples(data, contacts) - self.lookahead
        most = np.minimum(available, samples_in(at, data.layout.rate))
        place = np.searchsorted(self.lengths, most, side="right")
        return np.array([0, *self.lengths], np.intp)[place]


class AnytimeModel(Predictor):
    """Model in a model folder that predicts at one or several times after a contact.

    A subclass sets ``kind``, and implements the abstract methods of this class and of
    :class:`Predictor`. An :class:`AnytimeEstimator` makes the model from labelled contacts.
    """

    #: Name of the kind of model. The name in model files is :attr:`name`.
    kind: ClassVar[str]

    @property
    def name(self) -> str:
        return self.kind

    @abstractmethod
    def to_arrays(self) -> Arrays:
        """Return all arrays that predictions depend on, by name."""

    @classmethod
    @abstractmethod
    def from_arrays(cls, arrays: Arrays, level: float | None) -> Self:
        """Restore a model from its arrays. ``level`` is the nominal coverage of its intervals.

        Raise InputError if the shapes or values of the arrays do not fit together.
        """

    def with_record(self, record: TrainingRecord) -> Self:
        """Return a copy of the model that has ``record`` as the description of its training."""
        other = copy(self)
        other.record = record
        return other

    def card(self) -> AnytimeCard | WindowCard:
        """Return the model's entry in ``model.json``."""
        return AnytimeCard(kind=self.name, rate_hz=self.rate, record=self.record, level=self.level)


class PredictorLadder(Predictor):
    """Predictors of one estimator for several signal lengths, as one predictor.

    The predictor for the longest available signal predicts.
    """

    def __init__(self, steps: Sequence[Predictor]) -> None:
        self._steps = {step.lengths[-1]: step for step in steps}
        self._first = first = steps[0]
        self.rate, self.lookahead = first.rate, first.lookahead
        self.classes, self.level, self.quantity = first.classes, first.level, first.quantity
        self.lengths = sorted(self._steps)
        self.before = max(step.before for step in steps)

    @property
    def name(self) -> str:
        return self._first.name

    @property
    def prediction_times(self) -> tuple[float, ...]:
        return tuple(self._steps[n].prediction_times[-1] for n in self.lengths)

    def predict(
        self, signal: NDArray[np.float64], samples: int, finger: int, hints: Hints
    ) -> Prediction | None:
        return self._steps[samples].predict(signal, samples, finger, hints)

    def chain_constants(self) -> Constants:
        """Return the constants that the C chain needs, which describe all SVMs.

        If some models are not SVMs, or there are too many, return signal lengths only. The chain
        then calls :meth:`predict` in Python.
        """
        each = [self._steps[n].chain_constants() for n in self.lengths]
        svms = [svm for c in each if isinstance(c, WindowConstants) for svm in c.svms]
        constants = WindowConstants(self.before, self.lengths, self.lookahead)
        is_in_c = len(svms) == len(each) <= SVMS_MOST
        return replace(constants, svms=svms) if is_in_c else constants

    def check(self, layout: Layout) -> None:
        for step in self._steps.values():
            step.check(layout)


def contact_signal(
    pinch: Pinch, contact: Contact, before: int, after: int
) -> NDArray[np.float64] | None:
    """Return the vibration of the finger that touched, V, smoothed as the device smooths it.

    The signal has at most ``before`` samples before the contact and exactly ``after`` from it on.
    Return None if the finger has no sensor, or fewer samples follow the contact.
    """
    columns = pinch.layout.columns(ChannelKind.VIBRATION, contact.finger)
    start = contact.sample - pinch.first_sample
    if not columns or start < 0 or start + after > len(pinch.data):
        return None
    volts = pinch.layout.physical(pinch.data, columns)
    smooth = DeviceSmoothing(pinch.layout, columns).update(volts)
    out: NDArray[np.float64] = smooth[max(start - before, 0) : start + after, 0]
    return out
