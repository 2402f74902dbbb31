"""Predictors of a model, each with its interval and the record of its training."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from math import nan
from typing import ClassVar, Self

import numpy as np

from firstcontact.core import Contact, Dataset, InputError
from firstcontact.core.physics import parse_radius
from firstcontact.models.card import NetworkCard, TrainingRecord, WindowCard
from firstcontact.models.in_context import InContextModel
from firstcontact.models.interval import Interval
from firstcontact.models.predictions import Predictions
from firstcontact.models.registry import model_class
from firstcontact.models.touches import Touches, valid_samples
from firstcontact.models.window_model import Arrays, Spec, Task, Values, WindowModel, Windows
from firstcontact.signal import SavitzkyGolay, contact_windows, samples_in

#: Longest window that a model may require, s.
LONGEST_WINDOW = 10.0
#: Content of each channel of a window.
_CHANNELS = ("piezo of the finger that touched", "piezo of the other finger")


@dataclass(frozen=True, slots=True, eq=False)
class WindowPredictor:
    """Predictor that uses a window: the signal of a fixed length after a contact.

    ``interval`` gives the prediction intervals; None for a model without. ``record`` describes the
    training.
    """

    model: WindowModel
    interval: Interval | None = None
    record: TrainingRecord = field(default_factory=TrainingRecord)

    @property
    def name(self) -> str:
        """Name of the estimator."""
        return self.model.name

    @property
    def rate(self) -> float:
        """Sampling rate of the windows, Hz."""
        return self.model.spec.rate

    @property
    def moments(self) -> tuple[float, ...]:
        """Time after a contact at which the model predicts, s, in a tuple of length 1."""
        return (self.duration,)

    @property
    def duration(self) -> float:
        """Length of the window, s, rounded to 1 or 0.1 ms if that gives as many samples."""
        spec = self.model.spec
        for decimals in (3, 4):
            length = round(spec.duration, decimals)
            if samples_in(length, spec.rate) == spec.samples:
                return length
        return spec.duration

    @property
    def classes(self) -> tuple[float, ...]:
        """Classes that the model predicts; empty for a regression."""
        return self.model.spec.classes

    @property
    def level(self) -> float | None:
        """Nominal coverage of the prediction intervals, such as 0.9; None without intervals."""
        return None if self.interval is None else self.interval.level

    def predict(
        self, data: Dataset, contacts: Sequence[Contact | None], at: float = LONGEST_WINDOW
    ) -> Predictions:
        """Predict each pinch from the window after its first contact, given in ``contacts``.

        The prediction is NaN without a contact, if the second finger touches before the window and
        the filter's look-ahead end, or if the window is longer than ``at`` (s).
        """
        out = Predictions.empty(contacts)
        if at < self.duration - 1e-9:
            return out
        needed = self.model.spec.samples + SavitzkyGolay().lookahead
        is_valid = valid_samples(data, contacts) >= needed
        alone = [c if valid else None for c, valid in zip(contacts, is_valid, strict=True)]
        X, rows = contact_windows(data, alone, self.model.spec.duration)
        if not len(X):
            return out
        values, spreads, low, high = self.predict_windows(X)
        elapsed = np.full(len(values), self.duration)
        is_out = np.zeros(len(values), np.bool_)
        out.put(rows, Predictions(values, spreads, low, high, is_out, elapsed))
        return out

    def predict_windows(self, X: Windows) -> tuple[Values, Values, Values, Values]:
        """Return values, standard deviations, lower bounds and upper bounds, shape (n,) each.

        ``X`` holds windows in V, shape (n, samples, channels). Standard deviations are NaN if the
        model predicts none. Without intervals, both bounds equal the value.
        """
        values, spreads = self.model.predict(X), self.model.spread(X)
        if spreads is None:
            if self.interval is not None and self.interval.scaled:
                raise InputError(
                    "the interval needs a predicted standard deviation, but the model predicts "
                    "none: train it again"
                )
            spreads = np.full(len(values), nan)
        low = high = values
        if self.interval is not None:
            low, high = self.interval.around_all(values, spreads)
        return values, spreads, low, high

    def card(self) -> WindowCard:
        """Return the predictor's entry in ``model.json``."""
        spec = self.model.spec
        return WindowCard(
            kind=self.model.kind,
            rate_hz=spec.rate,
            record=replace(self.record, training=dict(self.model.notes)),
            task=spec.task,
            samples=spec.samples,
            channels=spec.channels,
            channel_order=_CHANNELS[: spec.channels],
            classes=spec.classes,
            interval=self.interval,
        )

    @classmethod
    def from_card(cls, card: WindowCard, arrays: Arrays) -> Self:
        """Create the predictor from its entry in ``model.json`` and its arrays. Check both."""
        kind = model_class(card.kind, of_windows=True)
        with np.errstate(all="ignore"):  # predictions that overflow are refused
            return cls(kind.from_arrays(_spec(card), arrays), card.interval, card.record)


@dataclass(frozen=True, slots=True, eq=False)
class RigPredictor:
    """Predictor that uses the pre-trained network, adapted to a rig (a hand with its sensors)."""

    #: Elapsed times after a contact at which the network predicts, s, ascending.
    moments: ClassVar[tuple[float, ...]] = tuple(
        n / 1000 for n in range(2, round(1000 * Touches.LONGEST) + 1)
    )
    #: Empty, because the network predicts Shore A, not classes.
    classes: ClassVar[tuple[float, ...]] = ()

    model: InContextModel
    record: TrainingRecord = field(default_factory=TrainingRecord)

    @property
    def name(self) -> str:
        """Name of the estimator."""
        return self.model.kind

    @property
    def rate(self) -> float:
        """Sampling rate of the signals, Hz."""
        return self.model.rate

    @property
    def level(self) -> float:
        """Nominal coverage of the intervals."""
        return self.model.level

    def predict(
        self, data: Dataset, contacts: Sequence[Contact | None], at: float = Touches.LONGEST
    ) -> Predictions:
        """Predict each pinch from the signal after its first contact, given in ``contacts``.

        The signal ends ``at`` s after the contact, or earlier at the second finger's contact.
        """
        out = Predictions.empty(contacts)
        touches, rows = Touches.cut(data, contacts)
        shapes = np.array([parse_radius(data[row].label.shape) for row in rows], np.float64)
        touches = replace(touches, radii=shapes)
        touches = touches.until(samples_in(at, touches.rate))
        enough = touches.valid >= self.model.shortest
        touches, rows = touches.take(enough), rows[enough]
        if len(rows):
            out.put(rows, self.model.predict(touches))
        return out

    def card(self) -> NetworkCard:
        """Return the predictor's entry in ``model.json``."""
        model = self.model
        return NetworkCard(
            kind=model.kind, rate_hz=model.rate, record=self.record, level=model.level
        )

    @classmethod
    def from_card(cls, card: NetworkCard, arrays: Arrays) -> Self:
        """Create the predictor from its entry in ``model.json`` and its arrays. Check both."""
        kind = model_class(card.kind, of_windows=False)
        return cls(kind.from_arrays(arrays, card.level), card.record)


#: Predictor of a model.
Predictor = WindowPredictor | RigPredictor


def _spec(card: WindowCard) -> Spec:
    spec = Spec(card.task, card.rate_hz, card.samples, card.channels, card.classes)
    if spec.duration > LONGEST_WINDOW:
        raise InputError(
            f"the model's window of {spec.samples} samples at {spec.rate:g} Hz is longer than "
            f"{LONGEST_WINDOW:g} s: train again with a shorter window"
        )
    if (spec.task is Task.CLASSIFICATION) != (len(spec.classes) > 1) or any(
        not one < other for one, other in zip(spec.classes, spec.classes[1:], strict=False)
    ):
        raise InputError(
            f"the field 'classes' does not fit the task {spec.task}, or its values do not ascend"
        )
    if card.channel_order != _CHANNELS[: spec.channels]:
        raise InputError(
            f"the field 'channel_order' is {list(card.channel_order)!r}, but this program's "
            f"windows have the channels {list(_CHANNELS[: spec.channels])!r}"
        )
    return spec
