"""Base classes of contact detectors, with and without training."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from firstcontact.chain.constants import DetectorConstants, DetectorKind
from firstcontact.contact.finder import LEAST_LOUD
from firstcontact.core import Dataset, InputError, Layout, ModelError, Pinch
from firstcontact.core.display import SKY
from firstcontact.signal import samples_in


@dataclass(frozen=True, slots=True)
class WindowSizes:
    """Lengths of a window, of the step between windows, and of the steady state, in samples."""

    window: int
    step: int
    steady: int


@dataclass(frozen=True, slots=True, eq=False)
class WindowDecisions:
    """Decisions of a detector for windows: a contact or none, for each window and channel."""

    #: Number of the last sample of each window, shape (windows,).
    ends: NDArray[np.int64]
    #: Mask of the windows with a contact in their newest part, shape (windows, channels).
    fired: NDArray[np.bool_]
    #: Number of the sample at which that contact began, -1 without one, same shape.
    onsets: NDArray[np.int64]


#: Largest number of samples of a steady state.
MOST = 1 << 14


class Detector:
    """Base class of contact detectors, which test a window of samples every ``step`` seconds.

    The steady state, the motor's noise before a contact, is measured in the first 40 ms of a stream
    and after each gap in it. Contacts are detected only after that, so the stream must begin when
    the hand begins to close. In live sessions the chain (the package's C code) finds this start,
    and for recordings :func:`firstcontact.contact.closing_start.cut_closings` does. A contact
    during the steady state makes its standard deviation large, so later contacts may be missed. A
    channel that is constant during the steady state has no contacts.
    """

    #: Name on the command line, in files and in results.
    name: ClassVar[str]
    #: Name in figures and messages, and colour in figures.
    title: ClassVar[str] = ""
    colour: ClassVar[str] = SKY
    #: True if :meth:`fit` learns from data.
    learns: ClassVar[bool] = False
    #: Length of a window, and time between the ends of two windows, s, as published.
    duration: ClassVar[float] = 0.020
    step: ClassVar[float] = 0.003
    #: Length of the steady state, s: two periods of 50 Hz hum.
    steady: ClassVar[float] = 0.040
    #: Number of newest steps in which a detected contact can have begun: the new part, and two
    #: steps before for contacts that were too faint.
    reach: ClassVar[int] = 3

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        if "title" not in vars(cls) and "name" in vars(cls):
            cls.title = cls.name.replace("_", " ")

    @property
    def rate(self) -> float | None:
        """Sampling rate that the samples must have, Hz; None, the default, if any is allowed."""
        return None

    def fit(self, dataset: Dataset, early: float = 0.0) -> Self:
        """Train the detector on pinches with labelled contacts, and return it.

        The base class does nothing. A label may be up to ``early`` s later than the true contact.
        Raise InputError if there are too few pinches for training.
        """
        return self

    @classmethod
    def untrained(cls, layout: Layout) -> Self:
        """Return a detector for this layout that needs no training data.

        The base class returns ``cls()``.
        """
        return cls()

    def to_arrays(self) -> dict[str, NDArray[np.float64]]:
        """Return all learned numbers and options as named arrays, to save them; none by default."""
        return {}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Self:
        """Restore a detector from the arrays of :meth:`to_arrays`. By default return ``cls()``."""
        return cls()

    def fires(self, windows: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return True for each window with a contact in its newest part, shape (windows, fingers).

        ``windows``, shape (windows, fingers, samples), are samples divided by the standard
        deviation of the motor's noise. The chain calls this method for one window at a time, unless
        it has a detector of this kind itself (see :meth:`chain_constants`).
        """
        raise NotImplementedError(f"{type(self).__name__} has no method 'fires'")

    def settled(self, quiet: NDArray[np.float64]) -> None:
        """Adapt to the motor's noise before a contact (steady state). By default do nothing.

        ``quiet`` holds samples of this noise divided by their standard deviation, shape (samples,
        fingers). The chain calls this method when the first steady state is complete, and again
        when a quieter one replaces it. A finger that keeps its earlier steady state keeps the
        earlier standard deviation.
        """

    @classmethod
    def sizes(cls, rate: float) -> WindowSizes:
        """Return the detector's lengths in samples at ``rate`` Hz.

        They are those of a window, of the step between windows, and of the steady motor signal
        before a contact.
        """
        return WindowSizes(
            samples_in(cls.duration, rate),
            max(1, samples_in(cls.step, rate)),
            samples_in(cls.steady, rate),
        )

    @classmethod
    def _constants(cls, rate: float, kind: DetectorKind, **constants: Any) -> DetectorConstants:
        """Return the constants with which the chain runs a detector of this class at ``rate``, Hz.

        ``constants`` are further fields of the result, which only this ``kind`` of detector needs.
        Raise ModelError if the detector cannot run at this rate.
        """
        sizes = cls.sizes(rate)
        if sizes.window < 2 * LEAST_LOUD:
            raise ModelError(
                f"the detector {cls.name!r} cannot locate contacts in samples at {rate:g} Hz: use "
                f"a sensor with {2 * LEAST_LOUD / cls.duration:g} Hz or more"
            )
        if sizes.steady > MOST:
            raise ModelError(
                f"the detector {cls.name!r} cannot use samples at {rate:g} Hz: use a sensor with "
                f"{MOST / cls.steady:g} Hz or less"
            )
        search = max(cls.reach * sizes.step, LEAST_LOUD)
        return DetectorConstants(kind, sizes.window, sizes.step, sizes.steady, search, **constants)

    def chain_constants(self, rate: float) -> DetectorConstants:
        """Return the constants with which the chain runs this detector at ``rate``, Hz.

        The chain is the C code for all steps from a sample to an estimate. With the constants that
        this base class returns, the chain calls :meth:`settled` and :meth:`fires`. Raise InputError
        if the detector cannot run at the rate.
        """
        return self._constants(rate, DetectorKind.PYTHON)


#: Largest stored weight. It keeps scores finite; trained weights are around 1.
LARGEST = 1e100


class TrainedDetector(Detector):
    """Base class of contact detectors that must be trained or loaded before use."""

    learns: ClassVar[bool] = True
    #: Lowest rate, Hz. Below it some part of a window has no samples.
    lowest: ClassVar[float]

    def __init__(self, seed: int = 0) -> None:
        self.seed = seed
        self._rate = 0.0

    @property
    @abstractmethod
    def trained(self) -> bool:
        """True if the detector was trained or loaded, so that it can detect contacts."""

    @property
    def rate(self) -> float | None:
        """Sampling rate of the training data, which samples must have, Hz; None before training."""
        return self._rate or None

    @property
    def noun(self) -> str:
        """Title of the detector as written within a sentence, such as "logistic" or "SVM"."""
        return self.title if self.title.isupper() else self.title.lower()

    def chain_constants(self, rate: float) -> DetectorConstants:
        self._check_rate(rate)
        return super().chain_constants(rate)

    def _check_rate(self, rate: float) -> None:
        self._require_training("fit it or load a trained one")
        if rate != self._rate:
            raise ModelError(
                f"the {self.title} detector was trained at {self._rate:g} Hz but the samples come "
                f"at {rate:g} Hz: train one for this rate with `firstcontact train --rate {rate:g}`"
            )

    def _require_training(self, otherwise: str) -> None:
        if not self.trained:
            raise ModelError(f"the {self.noun} detector has not been trained: {otherwise}")

    def _window_sizes(self, dataset: Dataset) -> tuple[float, WindowSizes]:
        """Return the sampling rate of the training data, Hz, and the lengths of windows at it.

        Raise ModelError if the rate is too low.
        """
        rate = dataset.layout.rate if len(dataset) else self.lowest
        if rate < self.lowest:
            raise ModelError(
                f"the {self.noun} detector needs samples at {self.lowest:g} Hz or more, not "
                f"{rate:g} Hz: use the detector 'three_sigma', which is not trained"
            )
        return rate, self.sizes(rate)

    def _too_few(self, count: int) -> InputError:
        return ModelError(
            f"only {count} pinches have a labelled first contact, a working sensor and at least 43 "
            f"ms of quiet before the contact, but the {self.noun} detector needs two: record more"
        )


def usable(pinch: Pinch, sizes: WindowSizes, early: float) -> bool:
    """Return True if a pinch has a known contact and enough samples before it for training."""
    if pinch.first is None:
        return False
    lead = pinch.first.sample - pinch.first_sample - samples_in(early, pinch.layout.rate)
    return lead >= sizes.steady + sizes.step


def spread_out(dataset: Dataset, sizes: WindowSizes, early: float, most: int) -> Dataset:
    """Return at most ``most`` pinches that are :func:`usable`, evenly spaced over the dataset."""
    usable_positions = np.flatnonzero([usable(p, sizes, early) for p in dataset.pinches])
    spaced = np.linspace(0, max(0, len(usable_positions) - 1), min(most, len(usable_positions)))
    return dataset.take(usable_positions[spaced.round().astype(np.intp)])


def stored_array(
    arrays: Mapping[str, NDArray[Any]], name: str, shape: tuple[int, ...]
) -> NDArray[np.float64]:
    """Return a named array of a saved detector. Raise ModelError if it is missing or damaged."""
    value = np.array(arrays.get(name, np.nan), dtype=np.float64)
    if value.shape != shape or not (np.abs(value) < LARGEST).all():
        raise ModelError(f"the detector's array {name!r} is missing or damaged: train it again")
    return value
