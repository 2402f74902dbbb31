"""Base class of detectors that judge sliding windows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from firstcontact.chain import DetectorConstants, DetectorKind
from firstcontact.contact._onset import LEAST_LOUD
from firstcontact.core import SKY, Dataset, InputError, Layout
from firstcontact.signal import samples_in


@dataclass(frozen=True, slots=True)
class WindowSizes:
    """Lengths of window, step and steady state in samples, at one rate."""

    window: int
    step: int
    steady: int


#: Largest number of samples of a steady state.
MOST = 1 << 14


class WindowDetector:
    """Detector that judges a window of ``duration`` after every ``step`` of new samples.

    The steady state is measured in the first 40 ms of a stream, and again in the first 40 ms after
    each gap. Decisions begin after the steady state. So a stream must start where a closing does:
    the gate ensures this live, and :func:`firstcontact.contact._closing_start.cut_closings` for
    pinches. A contact during the steady state makes its sigma large, so later contacts may be
    missed. A channel that is constant during the steady state never fires.
    """

    name: ClassVar[str]
    title: ClassVar[str] = ""
    colour: ClassVar[str] = SKY
    learns: ClassVar[bool] = False
    #: 17 ms of old and 3 ms of new samples, as published.
    duration: ClassVar[float] = 0.020
    step: ClassVar[float] = 0.003
    #: Two periods of 50 Hz hum.
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
        """Required sampling rate, Hz; None, the default, accepts any."""
        return None

    def fit(self, dataset: Dataset, early: float = 0.0) -> Self:
        """Learn from pinches with known contacts. By default do nothing."""
        return self

    @classmethod
    def untrained(cls, layout: Layout) -> Self:
        """Return a detector for a layout without training data, by default with default options."""
        return cls()

    def to_arrays(self) -> dict[str, NDArray[np.float64]]:
        """Return all learned numbers and options for saving. By default there are none."""
        return {}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Self:
        """Restore a detector from :meth:`to_arrays`. By default return a new one."""
        return cls()

    def fires(self, windows: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return a mask of the windows with a contact in their newest part.

        The chain calls this method for one window at a time, unless :meth:`constants` names a
        detector that is part of the chain.

        Parameters
        ----------
        windows
            Shape (windows, fingers, samples), in sigmas of the steady state.

        Returns
        -------
        ndarray
            Shape (windows, fingers).
        """
        raise NotImplementedError(f"{type(self).__name__} has no method 'fires'")

    def settled(self, quiet: NDArray[np.float64]) -> None:
        """Learn from a steady state. By default do nothing.

        This method is called when the first steady state is complete, and again when a quieter one
        replaces it.

        Parameters
        ----------
        quiet
            Samples of the steady state, in its sigmas, shape (samples, fingers). The samples of a
            finger that keeps its earlier steady state are in sigmas of that one.
        """

    @classmethod
    def sizes(cls, rate: float) -> WindowSizes:
        """Return the lengths of window, step and steady state, in samples, at a rate in Hz."""
        return WindowSizes(
            samples_in(cls.duration, rate),
            max(1, samples_in(cls.step, rate)),
            samples_in(cls.steady, rate),
        )

    @classmethod
    def _constants(cls, rate: float, kind: DetectorKind, **constants: Any) -> DetectorConstants:
        """Return constants with the lengths of this class, at a rate in Hz."""
        sizes = cls.sizes(rate)
        if sizes.window < 2 * LEAST_LOUD:
            raise InputError(
                f"the detector {cls.name!r} cannot locate contacts in samples at {rate:g} Hz: use "
                f"a sensor with {2 * LEAST_LOUD / cls.duration:g} Hz or more"
            )
        if sizes.steady > MOST:
            raise InputError(
                f"the detector {cls.name!r} cannot judge samples at {rate:g} Hz: use a sensor with "
                f"{MOST / cls.steady:g} Hz or less"
            )
        search = cls.reach * sizes.step
        return DetectorConstants(kind, sizes.window, sizes.step, sizes.steady, search, **constants)

    def constants(self, rate: float) -> DetectorConstants:
        """Return the constants of this detector for the chain at a rate in Hz.

        By default, the chain calls :meth:`settled` and :meth:`fires`.

        Raises
        ------
        InputError
            The rate is too low or too high, or the detector is not trained for it.
        """
        return self._constants(rate, DetectorKind.PROGRAM)
