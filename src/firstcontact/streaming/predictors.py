"""Live predictors: one interface for the network and for window models."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from firstcontact.core import Block, Contact, InputError, Layout
from firstcontact.core.physics import is_same_rate
from firstcontact.signal import ContactWindow, WindowStream

if TYPE_CHECKING:
    from firstcontact.chain.image import ModelConstants
    from firstcontact.chain.stream import Predict
    from firstcontact.models import Model, WindowPredictor
    from firstcontact.models.in_context import InContextModel

NOT_FINITE = "the model's prediction is not a finite number"


class Predictor:
    """Model that predicts at one or several moments after a contact."""

    #: Name of the estimator.
    name: str
    #: Sampling rate of the signals that the model needs, Hz.
    rate: float
    #: Elapsed times after a contact at which the model predicts, s, ascending.
    moments: tuple[float, ...]
    #: True if a measured closing speed, or the shape of the object, is an input of the model.
    uses_speed = False
    uses_shape = False
    #: Nominal share of truths inside the intervals of the chain's estimates.
    level = 0.0
    #: Constants of the chain; None for window models.
    constants: ModelConstants | None = None
    #: Function that predicts in place of the chain; None if the chain predicts.
    predict: Predict | None = None

    def check(self, layout: Layout) -> None:
        """Raise InputError if the model cannot be used with this layout."""

    def start(self, layout: Layout) -> WindowPredictions | None:
        """Return the window models of one closing; None if the chain predicts."""
        return None


class AnytimePredictor(Predictor):
    """Predictor with an any-time model that is conditioned on a rig, such as the network."""

    uses_shape = True

    def __init__(self, model: InContextModel) -> None:
        from firstcontact.models import Touches

        self.model = model
        self.name, self.rate, self.level = model.kind, model.rate, model.level
        self.moments = tuple(n / model.rate for n in Touches.moments(model.rate))
        #: True if the rig's own pinches had measured speeds. Without them, speeds cannot be used.
        self.uses_speed = any(rig.speeds is not None for rig in model.rigs.values())
        self.constants = model.constants()
        self.predict = None if model.is_compiled else _called(model)

    def check(self, layout: Layout) -> None:
        if not is_same_rate(layout.rate, self.model.rate):
            raise InputError(
                f"the network needs samples at {self.model.rate:g} Hz, but the source sends "
                f"{layout.rate:g} Hz: set the source to {self.model.rate:g} Hz, or use a model "
                f"folder with window models at {layout.rate:g} Hz"
            )


def _called(model: InContextModel) -> Predict:
    """Return the function with which the chain calls a model in Python."""
    from firstcontact.models import Touches

    def predict(
        signal: memoryview, samples: int, finger: int, speed: float, error: float, radius: float
    ) -> tuple[float, float, float, float, float, bool]:
        one = Touches(
            np.frombuffer(signal, np.float32)[None].copy(),
            np.array([samples]),
            np.array([finger]),
            np.array([speed or math.nan]),
            np.array([error]),
            np.array([radius]),
            model.rate,
        )
        p = model.predict(one)
        half_width = model.half_widths(p.spread, one.valid)
        numbers = (float(x[0]) for x in (p.value, p.low, p.high, half_width, p.spread))
        value, low, high, half, spread = numbers
        return value, low, high, half, spread, bool(p.out_of_range[0])

    return predict


class WindowLadder(Predictor):
    """Predictor with window models of one estimator: each predicts when its window is complete."""

    def __init__(self, windows: Sequence[WindowPredictor]) -> None:
        self._windows = {w.model.spec.duration: w for w in windows}
        self.name, self.rate = windows[0].name, windows[0].rate
        self.moments = tuple(sorted(self._windows))

    def check(self, layout: Layout) -> None:
        for window in self._windows.values():
            spec = window.model.spec
            spec.require_rate(layout.rate)
            if spec.channels != 1:
                raise InputError(
                    f"the model needs {spec.channels} channels, but live windows have only the "
                    "channel of the finger that touched: train a model on one channel"
                )
            # This loads what the model needs. It raises an error if weights overflow.
            ring = 0.1 * np.sin(np.arange(spec.samples))[:, None].astype(np.float32)
            made_up = ContactWindow(Contact(None, 0, 0), spec.duration, ring, 0)
            self.start(layout).predict(made_up)

    def start(self, layout: Layout) -> WindowPredictions:
        return WindowPredictions(self._windows, layout)


class WindowPredictions:
    """Predictions of window models in one closing."""

    def __init__(self, windows: dict[float, WindowPredictor], layout: Layout) -> None:
        self._windows = windows
        self._stream = WindowStream(layout, tuple(windows))
        self._left = len(windows)
        self._contact: Contact | None = None
        #: Reason why predictions are missing, "" if there is none.
        self.reason = ""

    @property
    def due(self) -> int | None:
        """Number of further samples until the next prediction; None if none can follow."""
        return self._stream.due

    @property
    def ended(self) -> bool:
        """True once no further prediction can come."""
        return self._left <= 0

    def update(self, block: Block, contact: Contact | None) -> list[ContactWindow]:
        """Process samples of the closing and its first contact. Return the complete windows."""
        new = () if contact is None or self._contact is not None else (contact,)
        self._contact = contact
        refused = self._stream.refused
        windows = self._stream.update(block, new)
        refused = self._stream.refused - refused
        self._left -= len(windows) + refused
        if refused:
            self.reason = "samples of the window are missing, or the piezo is dead"
        return windows

    def withdraw(self) -> None:
        self._left, self.reason, self._contact = len(self._windows), "", None
        self._stream.withdraw()

    def predict(self, window: ContactWindow) -> tuple[float, float, float, float]:
        """Return value, low, high, and the level of the interval, 0 without one."""
        entry = self._windows[window.duration]
        value, _, low, high = (float(a[0]) for a in entry.predict_windows(window.samples[None]))
        if not all(map(math.isfinite, (value, low, high))):
            raise InputError(NOT_FINITE)
        return value, low, high, entry.level or 0.0


def live_predictor(model: Model, estimator: str | None = None) -> Predictor | None:
    """Return the live predictor of a model; None for a model that holds a detector only."""
    from firstcontact.models.in_context import InContextModel

    if estimator is not None:
        model = model.only(estimator)
    if not model.predictors:
        return None
    rate = None if model.detector is None else model.detector.rate
    fitting = [p for p in model.predictors if rate is None or is_same_rate(p.rate, rate)]
    if not fitting:
        raise InputError(
            f"the detector needs samples at {rate:g} Hz, but no model in its folder does: train "
            f"both together, with `firstcontact train --rate {rate:g}` or another rate"
        )
    if isinstance(fitting[0].model, InContextModel):
        return AnytimePredictor(fitting[0].model)
    return WindowLadder([w for w in model.windows if w in fitting and w.name == fitting[0].name])
