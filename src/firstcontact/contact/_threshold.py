"""Published threshold detector: three sigmas of the steady state."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from firstcontact.chain.image import DetectorConstants, DetectorKind
from firstcontact.contact.detector import Detector
from firstcontact.core import InputError, Layout
from firstcontact.core.display import ORANGE

#: Threshold in sigmas for contacts from rest. Without a motor's noise, the sigma is small.
ABOVE_REST = 10.0
#: Largest threshold in a file.
HIGHEST = 1e6


class ThresholdDetector(Detector):
    """Detector that fires if a new sample is far from the mean of the steady state.

    The detector compares only the newest 3 ms of a window with the threshold, because it has
    compared the older samples in earlier windows. The same sample is therefore never reported
    twice.

    Parameters
    ----------
    sigmas
        Distance from the mean above which the detector fires, in sigmas of the steady state.

    Examples
    --------
    >>> from firstcontact.contact import detect
    >>> from firstcontact.testing.synthetic import closing
    >>> pinch = closing(5)
    >>> {contact.finger.name for contact in detect(ThresholdDetector(8.0), pinch)} != set()
    True
    """

    name: ClassVar[str] = "three_sigma"
    title: ClassVar[str] = "3σ threshold"
    colour: ClassVar[str] = ORANGE

    def __init__(self, sigmas: float = 3.0) -> None:
        self.sigmas = sigmas

    @classmethod
    def untrained(cls, layout: Layout) -> Self:
        """Return a detector with the published threshold.

        The threshold is higher for a layout with a sensor that is on no finger.
        """
        return cls(ABOVE_REST) if None in layout.vibration_fingers else cls()

    def to_arrays(self) -> dict[str, NDArray[np.float64]]:
        """Return the threshold, in sigmas, as a named array."""
        return {"sigmas": np.array(self.sigmas)}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Self:
        """Restore a detector from :meth:`to_arrays`."""
        sigmas = np.asarray(arrays.get("sigmas", np.nan))
        if sigmas.shape != () or not 0.0 < sigmas <= HIGHEST:
            raise InputError(
                "the detector's array 'sigmas' is missing, or its value is not above 0 and at "
                f"most {HIGHEST:g}: save the detector again"
            )
        return cls(float(sigmas))

    def constants(self, rate: float) -> DetectorConstants:
        """Return the constants of this detector for the chain at a rate in Hz."""
        return self._constants(rate, DetectorKind.THRESHOLD, threshold=self.sigmas)
