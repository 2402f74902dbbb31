"""Contact detectors, one a file."""

from firstcontact.contact.detector import Detector, Verdicts, detect
from firstcontact.contact.registry import DETECTORS, make_detector
from firstcontact.contact.svm import SvmDetector
from firstcontact.contact.threshold import ThresholdDetector

__all__ = [
    "DETECTORS",
    "Detector",
    "SvmDetector",
    "ThresholdDetector",
    "Verdicts",
    "detect",
    "make_detector",
]
