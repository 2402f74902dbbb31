"""Registered parts of a study, in the order of the report. A part is one file and one line."""

from __future__ import annotations

from firstcontact.core import Registry
from firstcontact_lab.study.part import Part

_HERE = "firstcontact_lab.study.parts"

PARTS: Registry[Part] = Registry(
    "study part",
    "firstcontact_lab.parts",
    {
        "data": f"{_HERE}.data:PART",
        "contacts": f"{_HERE}.contacts:PART",
        "waveforms": f"{_HERE}.waveforms:PART",
        "blocks": f"{_HERE}.blocks:PART",
        "objects": f"{_HERE}.objects:PART",
        "window_length": f"{_HERE}.window_length:PART",
        "second_contact": f"{_HERE}.second_contact:PART",
        "hardness": f"{_HERE}.hardness:PART",
        "short_windows": f"{_HERE}.short_windows:PART",
        "answer_time": f"{_HERE}.answer_time:PART",
        "anytime": f"{_HERE}.anytime:PART",
        "generalise": f"{_HERE}.generalise:PART",
        "inference": f"{_HERE}.inference:PART",
    },
    base="firstcontact_lab.study.part:Part",
    instances=True,
)
