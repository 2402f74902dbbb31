"""The nouns: small frozen types that every room shares."""

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
