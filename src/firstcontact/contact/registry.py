"""All detectors by name; a new one is one file and one line here."""

from __future__ import annotations

from firstcontact.contact.detector import Detector
from firstcontact.contact.svm import SvmDetector
from firstcontact.contact.threshold import ThresholdDetector
from firstcontact.core.errors import InputError

DETECTORS: dict[str, type[Detector]] = {
    ThresholdDetector.name: ThresholdDetector,
    SvmDetector.name: SvmDetector,
}


def make_detector(name: str) -> Detector:
    """A detector that still has to be fitted.

    Raises
    ------
    InputError
        When there is none of that name.
    """
    if name not in DETECTORS:
        raise InputError(f"no detector is called {name!r}: choose one of {', '.join(DETECTORS)}")
    return DETECTORS[name]()
