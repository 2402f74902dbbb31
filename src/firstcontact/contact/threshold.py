"""Published threshold detector: three standard deviations of the motor's noise."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from firstcontact.chain.constants import DetectorConstants, DetectorKind
from firstcontact.contact.detector import Detector
from firstcontact.core import Layout, ModelError
from firstcontact.core.display import ORANGE

#: Threshold in sigmas for contacts from rest. Without a motor's noise, the sigma is small.
ABOVE_REST = 10.0
#: Largest threshold in a file.
HIGHEST = 1e6


class ThresholdDetector(Detector):
    """Contact detector with a threshold on the distance of a sample from the mean.

    Mean and standard deviation are those of the steady state: the motor's noise before the contact.
    Only the newest 3 ms of a window are compared with the threshold, because earlier windows
    contained the older samples. The same sample is therefore never reported twice.

    Parameters
    ----------
    sigmas
        Distance from the mean above which a contact is reported, in standard deviations.

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
        """Return a detector with the published threshold, three standard deviations.

        The threshold is ten standard deviations if a sensor belongs to no finger.
        """
        return cls(ABOVE_REST) if None in layout.vibration_fingers else cls()

    def to_arrays(self) -> dict[str, NDArray[np.float64]]:
        return {"sigmas": np.array(self.sigmas)}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Self:
        sigmas = np.asarray(arrays.get("sigmas", np.nan))
        if sigmas.shape != () or not 0.0 < sigmas <= HIGHEST:
            raise ModelError(
                "the detector's array 'sigmas' must be one number above 0 and at most "
                f"{HIGHEST:g}: save the detector again"
            )
        return cls(float(sigmas))

    def chain_constants(self, rate: float) -> DetectorConstants:
        return self._constants(rate, DetectorKind.THRESHOLD, threshold=self.sigmas)
