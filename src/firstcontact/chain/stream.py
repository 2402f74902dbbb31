"""Class that runs the C chain on a stream of samples."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from firstcontact.chain._events import ChainEvent
from firstcontact.chain.image import Image, chain_extension
from firstcontact.core import (
    ArgumentError,
    Block,
    Calibration,
    ChannelKind,
    Finger,
    Layout,
)
from firstcontact.core.layout import FINGERTIP_SMOOTHING

#: Speed (m/s; 0 if unknown), its relative error, and the object's radius (m; NaN if unknown).
Hints = tuple[float, float, float]
#: Function of a signal (float64, as bytes), the number of samples in it before the contact, the
#: number after it that a prediction may use, the number of the finger, and the hints. It returns
#: value, low, high, half width, spread, and True if the contact is out of range; or None if the
#: signal is unusable.
Predict = Callable[
    [bytes, int, int, int, float, float, float],
    tuple[float, float, float, float, float, bool] | None,
]


class PythonDetector(Protocol):
    """Interface of a contact detector in Python, which the chain calls for each window."""

    def settled(self, quiet: NDArray[np.float64]) -> None:
        """Adapt to the motor's noise before a contact, shape (samples, fingers).

        ``quiet`` holds this noise, divided by its standard deviation.
        """

    def fires(self, windows: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return True for each window with a contact in its newest part, shape (windows, fingers).

        ``windows`` has the shape (windows, fingers, samples).
        """


class Chain:
    """Streaming C code that detects closings of the hand and contacts, and predicts stiffness.

    It turns blocks of samples into events. The events do not depend on the sizes of the blocks.

    Parameters
    ----------
    image
        Constants of detector and model; see :func:`build_image`. Their sampling rate must be that
        of the layout.
    layout
        Meaning of the columns of the blocks.
    calibration
        Noise of the sensors at rest. Without it, each epoch (run of the device's sample counter)
        counts as one closing.
    detector
        Detector in Python, for an image whose detector has the kind PYTHON.
    predict
        Function that predicts, for an image whose model is in Python.
    contact
        Function that is called with the sample number of each first contact, before its estimates,
        and returns the closing speed and the radius of the object (:data:`Hints`).
    keeps_first_state
        True to measure the motor's noise only once in each closing, and to withdraw no contact.
    is_traced
        True to evaluate all windows, and to store the decisions in :attr:`windows`.

    Attributes
    ----------
    windows
        Decisions of the last call, one row for each window: number of its last sample, and for each
        channel the sample number of the contact, -1 without one. Empty unless ``is_traced``.

    Raises
    ------
    InputError
        The layout has no vibration channel, or more than six.
    """

    def __init__(
        self,
        image: Image,
        layout: Layout,
        calibration: Calibration | None = None,
        *,
        detector: PythonDetector | None = None,
        predict: Predict | None = None,
        contact: Callable[[int], Hints] | None = None,
        keeps_first_state: bool = False,
        is_traced: bool = False,
    ) -> None:
        self._module = chain_extension()
        fingers = layout.vibration_fingers
        if not fingers:
            raise ArgumentError(
                "the layout has no vibration channel, so contacts cannot be detected: use a "
                "recording or device with a vibration sensor"
            )
        vibration = layout.columns(ChannelKind.VIBRATION)
        channels = layout.column_channels
        # The threshold of a load is in volts. In another unit it would hide every motor start.
        force = [i for i in layout.columns(ChannelKind.FORCE) if channels[i].unit == "V"]
        columns = [*vibration, *force]
        numbers = list(Finger)
        floors = [calibration.noise(f) if calibration else None for f in fingers]
        known_floors = [noise for noise in floors if noise is not None]
        has_floors = len(known_floors) == len(fingers)
        raw = [channels[i].smoothing_alpha == 1.0 for i in vibration]
        self.windows: list[tuple[int, ...]] = []
        self.has_floors = has_floors
        self._is_traced = is_traced
        self._functions = (
            None if detector is None else _settled(detector, len(fingers)),
            None if detector is None else _judge(detector, len(fingers)),
            predict,
            contact,
        )
        self._handle = self._module.chain(
            image.handle,
            np.array([-1 if f is None else numbers.index(f) for f in fingers], np.int32),
            np.where(raw, FINGERTIP_SMOOTHING, 1.0),
            np.array(known_floors if has_floors else [], np.float64),
            np.array(columns, np.int32),
            np.array([channels[i].offset for i in columns], np.float64),
            np.array([channels[i].scale for i in columns], np.float64),
            layout.width,
            None in fingers,
            keeps_first_state,
            is_traced,
            self._functions,
        )

    def take(self, block: Block) -> list[ChainEvent]:
        """Process the next block of samples. Return the events in it, in time order."""
        data = np.ascontiguousarray(block.data)
        if data.dtype.char not in "hHidf":
            data = data.astype(np.float64)
        first, epoch = block.first_sample, block.epoch
        return self._events(self._module.take(self._handle, data, first, epoch, self._functions))

    def finish(self) -> list[ChainEvent]:
        """End the closing in progress at the end of the stream. Return the last events."""
        return self._events(self._module.finish(self._handle, self._functions))

    def hint(self, speed: float, error: float, radius: float) -> None:
        """Set what is known besides the signal about the closing in progress, or else the next one.

        It is the closing speed (m/s, 0 if unknown), its relative error, and the object's radius
        (m).
        """
        self._module.hint(self._handle, speed, error, radius)

    def due(self, most: int) -> int:
        """Return the number of samples until the next event is possible, at most ``most``."""
        return int(self._module.state(self._handle, most)["due"])

    @property
    def is_open(self) -> bool:
        """True while the chain is in a closing, which ends some time after the first contact."""
        return bool(self._module.state(self._handle, 1)["is_open"])

    @property
    def runs(self) -> bool:
        """True from the start of a closing until the motor stops, also after the pinch's end."""
        return bool(self._module.state(self._handle, 1)["runs"])

    @property
    def refused(self) -> int:
        """Number of motor starts since the last closing that were ignored due to a high force."""
        return int(self._module.state(self._handle, 1)["refused"])

    @property
    def is_resting(self) -> bool:
        """True if the hand was at rest when the chain last checked the motor."""
        return bool(self._module.state(self._handle, 1)["is_resting"])

    @property
    def is_confirmed(self) -> bool:
        """True if the contacts of this closing are final: none can be withdrawn as false."""
        return bool(self._module.state(self._handle, 1)["is_confirmed"])

    def _events(self, result: Any) -> list[ChainEvent]:
        if self._is_traced:
            result, self.windows = result
        return [ChainEvent(*event) for event in result]


def _settled(detector: PythonDetector, fingers: int) -> Callable[[memoryview], None]:
    return lambda quiet: detector.settled(np.frombuffer(quiet).reshape(-1, fingers).copy())


def _judge(detector: PythonDetector, fingers: int) -> Callable[[memoryview], int]:
    def judge(windows: memoryview) -> int:
        fired = detector.fires(np.frombuffer(windows).reshape(1, fingers, -1).copy())[0]
        return sum(1 << k for k, has_contact in enumerate(fired) if has_contact)

    return judge
