"""Predictor that uses one fixed length of signal, with prediction intervals and card."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from math import nan
from typing import Self

import numpy as np
from numpy.typing import NDArray

from firstcontact.chain import Image, build_image
from firstcontact.chain.constants import WindowConstants
from firstcontact.chain.touch import predict_window
from firstcontact.core import Layout, ModelError
from firstcontact.core.quantity import SHORE_A, Quantity
from firstcontact.models.anytime import Hints, Prediction, Predictor
from firstcontact.models.card import TrainingRecord, WindowCard
from firstcontact.models.interval import Interval
from firstcontact.models.registry import model_class
from firstcontact.models.values import Arrays, Task, Values, Windows
from firstcontact.models.windows.window_model import Spec, WindowModel
from firstcontact.signal import SavitzkyGolay, samples_in
from firstcontact.signal.windowing import BASELINE, BASELINE_GUARD, cut_window

#: Longest window that a model may require, s.
LONGEST_WINDOW = 10.0
#: Content of each channel of a window.
_CHANNELS = ("piezo of the finger that touched", "piezo of the other finger")


class WindowPredictor(Predictor):
    """Predictor at one time: it uses a window, which is a signal of fixed length after the contact.

    ``interval`` is the rule for prediction intervals, or None. ``record`` describes the training.
    For a logarithmic ``quantity``, model and interval are on the scale of logarithms, but
    predictions are in its unit.
    """

    lookahead = SavitzkyGolay.lookahead

    def __init__(
        self,
        model: WindowModel,
        interval: Interval | None = None,
        record: TrainingRecord = Predictor.record,
        quantity: Quantity = SHORE_A,
    ) -> None:
        self.model, self.interval, self.record = model, interval, record
        self.quantity = quantity
        self.classes, self.rate = model.spec.classes, model.spec.rate
        self.level = None if interval is None else interval.level
        self.lengths = (model.spec.samples,)
        # The baseline and the filter use these samples.
        quiet = samples_in(BASELINE_GUARD, self.rate) + samples_in(BASELINE, self.rate)
        self.before = quiet + self.lookahead

    @property
    def name(self) -> str:
        return self.model.name

    @property
    def prediction_times(self) -> tuple[float, ...]:
        return (self.duration,)

    @property
    def duration(self) -> float:
        """Length of the window, s, rounded to 1 ms or 0.1 ms if the samples stay the same."""
        spec = self.model.spec
        for decimals in (3, 4):
            length = round(spec.duration, decimals)
            if samples_in(length, spec.rate) == spec.samples:
                return length
        return spec.duration

    def predict(
        self, signal: NDArray[np.float64], samples: int, finger: int, hints: Hints
    ) -> Prediction | None:
        start = len(signal) - samples - self.lookahead
        if self._image is not None:
            made = predict_window(self._image, signal, start)
            return None if made is None else Prediction(*made)
        conditioned = SavitzkyGolay().update(signal[:, None])
        window = cut_window(conditioned[:, 0], start, samples, self.rate)
        if window is None:
            return None
        value, spread, low, high = (float(a[0]) for a in self.predict_windows(window[None]))
        return Prediction(value, low, high, spread=spread)

    def chain_constants(self) -> WindowConstants:
        """Return the constants that the C chain needs for predictions.

        They hold an SVM, if the C chain can compute the model. Otherwise the chain calls Python.
        """
        svm, rule = self.model.chain_constants(), self.interval
        constants = WindowConstants(self.before, self.lengths, self.lookahead)
        if svm is None or (rule is not None and rule.scaled) or self.model.spec.channels > 1:
            return constants
        if rule is not None:
            limits = rule.limits or svm.limits
            svm = replace(svm, edges=rule.edges, half_widths=rule.half_widths, limits=limits)
        svm = replace(svm, is_logarithmic=self._is_logarithmic)
        return replace(constants, svms=(svm,))

    @cached_property
    def _image(self) -> Image | None:
        constants = self.chain_constants()
        return build_image(self.rate, model=constants) if constants.svms else None

    def check(self, layout: Layout) -> None:
        spec = self.model.spec
        spec.require_rate(layout.rate)
        if spec.channels != 1:
            raise ModelError(
                f"the model needs {spec.channels} channels, but a contact has only the channel of "
                "the finger that touched: train a model on one channel"
            )
        # This loads what the model needs. It raises an error if weights overflow.
        self.predict_windows(
            0.1 * np.sin(np.arange(spec.samples))[None, :, None].astype(np.float32)
        )

    def predict_windows(self, X: Windows) -> tuple[Values, Values, Values, Values]:
        """Return predictions, standard deviations, lower bounds and upper bounds, shape (n,) each.

        ``X`` holds windows in V, shape (n, samples, channels). Standard deviations are NaN if the
        model predicts none. Without intervals, both bounds equal the prediction.
        """
        values, spreads = self.model.predict(X), self.model.spread(X)
        if spreads is None:
            if self.interval is not None and self.interval.scaled:
                raise ModelError(
                    "the interval needs a predicted standard deviation, but the model predicts "
                    "none: train it again"
                )
            spreads = np.full(len(values), nan)
        low = high = values
        if self.interval is not None:
            low, high = self.interval.around_all(values, spreads)
        if self._is_logarithmic:
            values, low, high = map(self.quantity.restored, (values, low, high))
            spreads = spreads * values
        return values, spreads, low, high

    @property
    def _is_logarithmic(self) -> bool:
        return self.quantity.is_logarithmic and not self.classes

    def to_arrays(self) -> Arrays:
        return self.model.to_arrays()

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
    def from_card(cls, card: WindowCard, arrays: Arrays, quantity: Quantity = SHORE_A) -> Self:
        """Restore the predictor from its card and arrays. Raise InputError if these do not fit."""
        kind = model_class(card.kind, of_windows=True)
        with np.errstate(all="ignore"):  # predictions that overflow are refused
            return cls(kind.from_arrays(_spec(card), arrays), card.interval, card.record, quantity)


def _spec(card: WindowCard) -> Spec:
    spec = Spec(card.task, card.rate_hz, card.samples, card.channels, card.classes)
    if spec.duration > LONGEST_WINDOW:
        raise ModelError(
            f"the model's window of {spec.samples} samples at {spec.rate:g} Hz is longer than "
            f"{LONGEST_WINDOW:g} s: train again with a shorter window"
        )
    if (spec.task is Task.CLASSIFICATION) != (len(spec.classes) > 1) or any(
        not one < other for one, other in zip(spec.classes, spec.classes[1:], strict=False)
    ):
        raise ModelError(
            f"the field 'classes' does not fit the task {spec.task}, or its values do not ascend"
        )
    if card.channel_order != _CHANNELS[: spec.channels]:
        raise ModelError(
            f"the field 'channel_order' is {list(card.channel_order)!r}, but this program's "
            f"windows have the channels {list(_CHANNELS[: spec.channels])!r}"
        )
    return spec
