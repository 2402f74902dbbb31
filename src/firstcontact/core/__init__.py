"""The nouns: small frozen types that every room shares.

Each is imported when it is first asked for, so that ``firstcontact --help`` needs none of them.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from firstcontact.core.block import Block, joined
    from firstcontact.core.calibration import Calibration, ForceCurve, PiezoCalibration
    from firstcontact.core.command import Command
    from firstcontact.core.errors import InputError
    from firstcontact.core.layout import (
        Channel,
        ChannelKind,
        Finger,
        Layout,
        Physical,
        fingertip_layout,
    )
    from firstcontact.core.pinch import Contact, Dataset, Label, Pinch, Role
else:
    _WHERE = {
        "Block": "block",
        "Calibration": "calibration",
        "Channel": "layout",
        "ChannelKind": "layout",
        "Command": "command",
        "Contact": "pinch",
        "Dataset": "pinch",
        "Finger": "layout",
        "ForceCurve": "calibration",
        "InputError": "errors",
        "Label": "pinch",
        "Layout": "layout",
        "Physical": "layout",
        "PiezoCalibration": "calibration",
        "Pinch": "pinch",
        "Role": "pinch",
        "fingertip_layout": "layout",
        "joined": "block",
    }

    def __getattr__(name: str) -> object:
        if name not in _WHERE:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        return getattr(import_module(f"{__name__}.{_WHERE[name]}"), name)


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
    "InputError",
    "Label",
    "Layout",
    "Physical",
    "PiezoCalibration",
    "Pinch",
    "Role",
    "fingertip_layout",
    "joined",
]
