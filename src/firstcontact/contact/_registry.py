"""All detectors by name; a new one is one file and one line here."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from firstcontact.contact._detector import Detector
    from firstcontact.core import Layout
from firstcontact.core import Registry

DETECTORS: Registry[type[Detector]] = Registry(
    "detector",
    "firstcontact.detectors",
    {
        "three_sigma": "firstcontact.contact._threshold:ThresholdDetector",
        "svm": "firstcontact.contact._svm:SvmDetector",
        "logistic": "firstcontact.contact._logistic:LogisticDetector",
    },
    default="logistic",
    base="firstcontact.contact._detector:Detector",
)


def make_detector(name: str, **options: Any) -> Detector:
    """A detector that still has to be fitted.

    Parameters
    ----------
    name
        One of :data:`DETECTORS`.
    options
        Of its constructor.

    Raises
    ------
    InputError
        When there is none of that name.
    """
    kind = DETECTORS.find(name)
    with DETECTORS.calling(name):
        return kind(**options)


def untrained_name() -> str:
    """Name of the first detector that learns nothing: it is there where others cannot learn."""
    return next(name for name, kind in DETECTORS.items() if not kind.learns)


def untrained_detector(layout: Layout) -> Detector:
    """What finds contacts on a layout where nothing was learned from."""
    kind: Any = DETECTORS[untrained_name()]
    made: Detector = kind.untrained(layout) if hasattr(kind, "untrained") else kind()
    return made
