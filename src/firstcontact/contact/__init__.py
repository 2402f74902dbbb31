"""Contact detectors, one a file."""

from __future__ import annotations

from typing import TYPE_CHECKING

from firstcontact.core.lazy import lazily

if TYPE_CHECKING:
    from firstcontact.contact.detector import Detector, WindowDecisions, detect
    from firstcontact.contact.detector_file import load_detector, save_detector
    from firstcontact.contact.registry import DETECTORS, make_detector, unfitted, untrained
    from firstcontact.contact.stream import WindowDetector
    from firstcontact.contact.svm import SvmDetector
    from firstcontact.contact.threshold import ThresholdDetector
else:
    __getattr__ = lazily(
        __name__,
        {
            "detector": "Detector WindowDecisions detect",
            "detector_file": "load_detector save_detector",
            "registry": "DETECTORS make_detector unfitted untrained",
            "stream": "WindowDetector",
            "svm": "SvmDetector",
            "threshold": "ThresholdDetector",
        },
    )

__all__ = [
    "DETECTORS",
    "Detector",
    "SvmDetector",
    "ThresholdDetector",
    "WindowDecisions",
    "WindowDetector",
    "detect",
    "load_detector",
    "make_detector",
    "save_detector",
    "unfitted",
    "untrained",
]
