"""Registry of contact detectors. To add a detector, write one file and add one line here."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from firstcontact.contact.detector import Detector
    from firstcontact.contact.slip import SlipDetector
    from firstcontact.core import Layout
from firstcontact.core import Registry

DETECTORS: Registry[type[Detector]] = Registry(
    "detector",
    "firstcontact.detectors",
    {
        "three_sigma": "firstcontact.contact.threshold:ThresholdDetector",
        "svm": "firstcontact.contact.svm:SvmDetector",
        "logistic": "firstcontact.contact.logistic:LogisticDetector",
    },
    default="logistic",
    base="firstcontact.contact.detector:Detector",
)

SLIP_DETECTORS: Registry[type[SlipDetector]] = Registry(
    "slip detector",
    "firstcontact.slip_detectors",
    {"power": "firstcontact.contact.slip:PowerSlipDetector"},
    default="power",
    base="firstcontact.contact.slip:SlipDetector",
)


def make_detector(name: str, **options: Any) -> Detector:
    """Return an untrained detector by its name. ``options`` are arguments of its constructor."""
    kind = DETECTORS.find(name)
    with DETECTORS.convert_errors(name):
        return kind(**options)


def untrained_name() -> str:
    """Return the name of the first registered detector that needs no training."""
    return next(name for name, kind in DETECTORS.items() if not kind.learns)


def untrained_detector(layout: Layout) -> Detector:
    """Return a detector that needs no training, with a threshold suited to this layout."""
    return DETECTORS[untrained_name()].untrained(layout)
