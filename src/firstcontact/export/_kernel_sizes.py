"""Lengths that kernels are built with: what an image of a model must agree with."""

from __future__ import annotations

from firstcontact.contact import WindowDetector
from firstcontact.models import COMPONENTS

#: Names in the order in which an image tells their values.
TOLD = (
    "FC_WINDOW", "FC_STEP", "FC_STEADY", "FC_SEARCH", "FC_RING", "FC_LOOK", "FC_LOOKS", "FC_QUIET",
    "FC_ORDER", "FC_PARTS", "FC_LONGEST", "FC_BEFORE", "FC_BESIDE", "FC_FEATURES", "FC_HEADS",
    "FC_HIDDEN", "FC_FOUND", "FC_WIDEST", "FC_COMPONENTS",
)  # fmt: skip
#: What the kernels themselves fix: orders of prediction, parts of a look, features of a contact.
OF_KERNELS = {"FC_ORDER": 12, "FC_PARTS": 5, "FC_FEATURES": 14, "FC_COMPONENTS": COMPONENTS}


def detector_sizes(detector: WindowDetector, rate: float) -> dict[str, int]:
    """Return the sizes of a fitted detector, in samples at a rate in Hz."""
    lengths = detector.sizes(rate)
    return {
        "FC_WINDOW": lengths.window,
        "FC_STEP": lengths.step,
        "FC_STEADY": lengths.steady,
        "FC_SEARCH": detector.reach * lengths.step,
        "FC_RING": 1 << lengths.window.bit_length(),
        **detector.judgement(rate).sizes,
    }
