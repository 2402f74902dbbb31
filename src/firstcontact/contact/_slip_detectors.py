"""Registry of slip detectors. To add a detector, write one file and add one line here."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from firstcontact.contact._slip import SlipDetector
from firstcontact.core import Registry

SLIP_DETECTORS: Registry[type[SlipDetector]] = Registry(
    "slip detector",
    "firstcontact.slip_detectors",
    {"power": "firstcontact.contact._slip:PowerSlipDetector"},
    default="power",
    base="firstcontact.contact._slip:SlipDetector",
)
