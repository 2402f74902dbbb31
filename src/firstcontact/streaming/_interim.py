# mypy: ignore-errors
# ruff: noqa
"""Stand-ins until detectors and models give their constants."""

from typing import Any

from firstcontact.chain import DetectorConstants, DetectorKind
from firstcontact.contact import ThresholdDetector
from firstcontact.contact._logistic import AWAKE, FLOOR, LOOKS, LogisticDetector, parts


def detector_constants(detector: Any, layout: Any) -> DetectorConstants:
    rate = layout.rate
    if hasattr(detector, "constants"):
        return detector.constants(rate)
    detector.start(layout)
    sizes = detector.sizes(rate)
    lengths = sizes.window, sizes.step, sizes.steady, detector.reach * sizes.step
    if type(detector) is LogisticDetector:
        return DetectorConstants(
            DetectorKind.LOGISTIC, *lengths, LOOKS, parts(rate), AWAKE, FLOOR, detector._line
        )
    if type(detector) is ThresholdDetector:
        return DetectorConstants(DetectorKind.THRESHOLD, *lengths, threshold=detector.sigmas)
    return DetectorConstants(DetectorKind.PROGRAM, *lengths)
