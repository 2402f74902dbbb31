"""Live predictors: one interface for the network and for window models."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np

from firstcontact.core import Block, ClosingSpeed, Contact, InputError, Layout, is_same_rate
from firstcontact.models import (
    ANY,
    BEFORE,
    LONGEST,
    InContextModel,
    SingleContactPredictor,
    Touches,
    TouchStream,
)
from firstcontact.signal import ContactWindow, WindowStream, samples_in

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from firstcontact.models import Model, WindowPredictor

#: Number of moments up to which separate predictions are faster than one call for all, in real
#: time.
FEW = 4
_NOT_FINITE = "the model's prediction is not a finite number"


@dataclass(frozen=True, slots=True, kw_only=True)
class Prediction:
    """Prediction from the signal up to one moment after the contact.

    Parameters
    ----------
    value, low, high, level
        See :class:`firstcontact.streaming.Estimate`.
    elapsed
        Length of the signal after the contact, s.
    complete
        Last sample that the prediction depends on, with the look-ahead of filters.
    out_of_range, half_width
        See :class:`firstcontact.streaming.Estimate`.
    """

    value: float
    low: float
    high: float
    level: float
    elapsed: float
    complete: int
    out_of_range: bool = False
    half_width: float | None = None


class PredictionStream(Protocol):
    """Stream of predictions for the first contact of one closing, while its samples arrive."""

    @property
    def reason(self) -> str:
        """Reason why predictions are missing, "" if there is none."""

    @property
    def due(self) -> int | None:
        """Number of further samples until the next prediction; None if none can follow."""

    @property
    def ended(self) -> bool:
        """True once no further prediction can come."""

    def update(self, block: Block, contact: Contact | None) -> Iterator[Prediction]:
        """Yield the predictions that these samples complete. Exhaust the iterator.

        ``contact`` is the first contact, given with the block in which it was detected. InputError
        is raised if the model cannot predict from the signal.
        """

    def set_speed(self, measured: ClosingSpeed | None) -> None:
        """Set the measured closing speed. Called before the update with the contact."""

    def prepare(self) -> None:
        """Prepare the next prediction. Called once the events of a block were delivered."""

    def withdraw(self) -> None:
        """Discard the contact, and wait for another contact."""


class Predictor(Protocol):
    """Model that predicts at one or several moments after a contact."""

    @property
    def name(self) -> str:
        """Name of the estimator."""

    @property
    def rate(self) -> float:
        """Sampling rate of the signals that the model needs, Hz."""

    @property
    def moments(self) -> tuple[float, ...]:
        """Elapsed times after a contact at which the model predicts, s, ascending."""

    @property
    def uses_speed(self) -> bool:
        """True if a measured closing speed is an input of the model."""

    @property
    def uses_shape(self) -> bool:
        """True if the shape of the object is an input of the model."""

    def check(self, layout: Layout) -> None:
        """Raise InputError if the model cannot be used with this layout."""

    def start(
        self, layout: Layout, radius: float = math.nan, *, real_time: bool = False
    ) -> PredictionStream:
        """Return a stream for one closing.

        Parameters
        ----------
        layout
            Columns of the blocks.
        radius
            Radius of the object, m: infinite for a flat object, NaN if unknown.
        real_time
            True to make due predictions one by one, so that the first is available early.
        """

    def warm(self) -> None:
        """Predict once for an artificial contact, to load the model into the processor's caches."""


class NetworkPredictor:
    """Predictor with the network. It predicts after each millisecond.

    Parameters
    ----------
    model
        Network, conditioned on a rig.
    """

    uses_shape = True

    def __init__(self, model: InContextModel) -> None:
        from firstcontact.models import moments

        self.model = model
        self.name, self.rate = model.kind, model.rate
        self.moments = tuple(n / model.rate for n in moments(model.rate))
        #: True if the rig's own pinches had measured speeds. Without them, speeds cannot be used.
        self.uses_speed = any(rig.speeds is not None for rig in model.rigs.values())
        touches = _made_up_contact(model.rate)
        self._warming = model.follow(touches), touches.waves[0], int(touches.valid[0])

    def check(self, layout: Layout) -> None:
        """Raise InputError if the layout's sampling rate is not the model's."""
        if not is_same_rate(layout.rate, self.model.rate):
            raise InputError(
                f"the network takes samples at {self.model.rate:g} Hz, but the source sends "
                f"{layout.rate:g} Hz: set the source to {self.model.rate:g} Hz, or use a model "
                f"folder with window models at {layout.rate:g} Hz"
            )

    def start(
        self, layout: Layout, radius: float = math.nan, *, real_time: bool = False
    ) -> PredictionStream:
        """Return a stream for one closing."""
        return _NetworkStream(self.model, layout, radius, FEW if real_time else 1)

    def warm(self) -> None:
        """Predict once for an artificial contact."""
        contact, signal, valid = self._warming
        contact.predict(signal, valid)


def _made_up_contact(rate: float) -> Touches:
    lead, longest = samples_in(BEFORE, rate), samples_in(LONGEST, rate)
    t = np.arange(-lead, longest) / rate
    ring = np.where(t > 0, np.exp(-t.clip(0) / 0.01) * np.sin(900.0 * t), 0.01 * np.sin(900.0 * t))
    signals = ring[None].astype(np.float32)
    return Touches.from_signals(signals, np.full(1, longest), np.full(1, ANY), rate)


class _NetworkStream:
    """Predictions of the network in one closing."""

    def __init__(self, model: InContextModel, layout: Layout, radius: float, few: int) -> None:
        self._model, self._rate, self._few = model, layout.rate, few
        self._stream = TouchStream(layout, radius)
        self._contact: Contact | None = None
        self._answers: SingleContactPredictor | None = None

    @property
    def reason(self) -> str:
        return self._stream.refused

    @property
    def due(self) -> int | None:
        return self._stream.due

    @property
    def ended(self) -> bool:
        return self._stream.ended

    def update(self, block: Block, contact: Contact | None) -> Iterator[Prediction]:
        self._contact = self._contact or contact
        counts = self._stream.advance(block, contact)
        if not counts or self._contact is None:
            return
        if self._answers is None:
            self._answers = self._model.follow(self._stream.touches(counts[:1]))
        if self._answers.is_compiled or (self._answers.fits and len(counts) <= self._few):
            wave = self._stream.wave
            for samples in counts:
                yield self._predict(self._answers, wave, samples)
            return
        touches = self._stream.touches(counts)
        features = np.repeat(self._answers.features, len(touches), axis=0)
        rows = self._model.predict(touches, features)
        if not (np.isfinite(rows.value) & np.isfinite(rows.low) & np.isfinite(rows.high)).all():
            raise InputError(_NOT_FINITE)
        half_widths = self._model.half_widths(rows.spread, touches.valid, self._rate)
        for i, samples in enumerate(touches.valid.tolist()):
            yield Prediction(
                value=float(rows.value[i]),
                low=float(rows.low[i]),
                high=float(rows.high[i]),
                level=self._model.level,
                elapsed=samples / self._rate,
                complete=self._contact.sample + samples - 1,
                out_of_range=bool(rows.out_of_range[i]),
                half_width=float(half_widths[i]),
            )

    def _predict(
        self, answers: SingleContactPredictor, signal: NDArray[np.float32], samples: int
    ) -> Prediction:
        answer = answers.predict(signal, samples)
        if answer is None or self._contact is None:
            raise InputError(_NOT_FINITE)
        return Prediction(
            value=answer.value,
            low=answer.low,
            high=answer.high,
            level=self._model.level,
            elapsed=samples / self._rate,
            complete=self._contact.sample + samples - 1,
            out_of_range=answer.out_of_range,
            half_width=answer.half_width,
        )

    def set_speed(self, measured: ClosingSpeed | None) -> None:
        self._stream.speed = measured

    def prepare(self) -> None:
        if self._answers is None and (touches := self._stream.approach()) is not None:
            self._answers = self._model.follow(touches)

    def withdraw(self) -> None:
        self._contact = self._answers = None
        self._stream.withdraw()


class WindowLadder:
    """Predictor with several window models: each predicts when its window is complete.

    Parameters
    ----------
    windows
        Models of one estimator with their intervals, one for each length of the window.

    Raises
    ------
    InputError
        There is no model, or two models have windows of the same length.
    """

    uses_shape = uses_speed = False

    def __init__(self, windows: Sequence[WindowPredictor]) -> None:
        self._windows = {w.model.spec.duration: w for w in windows}
        if len(self._windows) < len(windows):
            raise InputError(
                "two models are for windows of the same length: give one of each length"
            )
        if not windows:
            raise InputError("no window model is given: name at least one")
        self.name, self.rate = windows[0].name, windows[0].rate
        self.moments = tuple(sorted(self._windows))
        ring = _made_up_contact(self.rate).waves[0]
        self._warming = {
            duration: np.resize(ring, (w.model.spec.samples, w.model.spec.channels))
            for duration, w in self._windows.items()
        }

    def check(self, layout: Layout) -> None:
        """Raise InputError if the sampling rate differs, or a model takes several channels."""
        for window in self._windows.values():
            spec = window.model.spec
            spec.require_rate(layout.rate)
            if spec.channels != 1:
                raise InputError(
                    f"the model takes {spec.channels} channels, but live windows have only the "
                    "channel of the finger that touched: train a model on one channel"
                )

    def start(
        self, layout: Layout, radius: float = math.nan, *, real_time: bool = False
    ) -> PredictionStream:
        """Return a stream for one closing."""
        return _WindowsStream(self._windows, layout)

    def warm(self) -> None:
        """Predict once per window for an artificial contact, so that the first real one is fast."""
        for duration, window in self._windows.items():
            window.model.predict_one(self._warming[duration])


class _WindowsStream:
    """Predictions of window models in one closing."""

    def __init__(self, windows: dict[float, WindowPredictor], layout: Layout) -> None:
        self._windows = windows
        self._stream = WindowStream(layout, tuple(windows))
        self._left = len(windows)
        self.reason = ""

    @property
    def due(self) -> int | None:
        return self._stream.due

    @property
    def ended(self) -> bool:
        return self._left <= 0

    def update(self, block: Block, contact: Contact | None) -> Iterator[Prediction]:
        refused = self._stream.refused
        windows = self._stream.update(block, () if contact is None else (contact,))
        refused = self._stream.refused - refused
        self._left -= len(windows) + refused
        if refused:
            self.reason = "samples of the window are missing, or the piezo is dead"
        for window in windows:
            yield self._predict(window)

    def set_speed(self, measured: ClosingSpeed | None) -> None:
        pass  # no window model uses it

    def prepare(self) -> None:
        pass  # a window model needs the whole window

    def withdraw(self) -> None:
        self._left, self.reason = len(self._windows), ""
        self._stream.withdraw()

    def _predict(self, window: ContactWindow) -> Prediction:
        entry = self._windows[window.duration]
        value = entry.model.predict_one(window.samples)
        low, high, level = value, value, 0.0
        if (interval := entry.interval) is not None:
            spread = entry.model.spread(window.samples[None]) if interval.scaled else np.ones(1)
            if spread is None:
                raise InputError(
                    "the interval needs an uncertainty of each prediction, but this model gives "
                    "none: train it again"
                )
            low, high = interval.around(value, float(spread[0]))
            level = interval.level
        if not all(map(math.isfinite, (value, low, high))):
            raise InputError(_NOT_FINITE)
        return Prediction(
            value=value,
            low=low,
            high=high,
            level=level,
            elapsed=window.duration,
            complete=window.complete,
        )


def live_predictor(model: Model, estimator: str | None = None) -> Predictor | None:
    """Return the live predictor of a model; None for a model that holds a detector only.

    As in :meth:`Model.predict`, the model's first estimator predicts. Estimators whose sampling
    rate is not the detector's are left out.

    Parameters
    ----------
    model
        Trained model.
    estimator
        Name of another estimator of the model.

    Raises
    ------
    InputError
        The model has no such estimator, or none with the detector's sampling rate.
    """
    if estimator is not None:
        model = model.only(estimator)
    if not model.predictors:
        return None
    rate = None if model.detector is None else model.detector.rate
    fitting = [p for p in model.predictors if rate is None or is_same_rate(p.rate, rate)]
    if not fitting:
        raise InputError(
            f"the detector takes {rate:g} samples a second, and no model has this rate: train "
            f"them together, with --rate {rate:g} or another"
        )
    if isinstance(fitting[0].model, InContextModel):
        return NetworkPredictor(fitting[0].model)
    return WindowLadder([w for w in model.windows if w in fitting and w.name == fitting[0].name])
