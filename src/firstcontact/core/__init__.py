"""The nouns: small frozen types that every room shares."""

from __future__ import annotations

from typing import TYPE_CHECKING

from firstcontact.core.lazy import lazily

if TYPE_CHECKING:
    from firstcontact.core.block import Block, joined
    from firstcontact.core.calibration import Calibration, ForceCurve, VibrationCalibration
    from firstcontact.core.command import Command
    from firstcontact.core.errors import InputError
    from firstcontact.core.layout import (
        Channel,
        ChannelKind,
        Finger,
        Group,
        Layout,
        Physical,
        VibrationSensor,
        finger_name,
        fingertip_layout,
    )
    from firstcontact.core.pinch import Contact, Dataset, Label, Pinch, Role
else:
    __getattr__ = lazily(
        __name__,
        {
            "block": "Block joined",
            "calibration": "Calibration ForceCurve VibrationCalibration",
            "command": "Command",
            "errors": "InputError",
            "layout": (
                "Channel ChannelKind Finger Group Layout Physical VibrationSensor finger_name "
                "fingertip_layout"
            ),
            "pinch": "Contact Dataset Label Pinch Role",
        },
    )

__all__ = [
    "Block",
    "Calibration",
    "Channel",
    "ChannelKind",
    "Command",
    "Contact",
    "Dataset",
    "Finger",
    "ForceCurve",
    "Group",
    "InputError",
    "Label",
    "Layout",
    "Physical",
    "Pinch",
    "Role",
    "VibrationCalibration",
    "VibrationSensor",
    "finger_name",
    "fingertip_layout",
    "joined",
]
