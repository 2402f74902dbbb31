"""Parts of a study, by name, in the order of the report."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from firstcontact.core import Registry

if TYPE_CHECKING:
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
        "stiffness": f"{_HERE}.stiffness:PART",
        "hardness": f"{_HERE}.hardness:PART",
        "short_windows": f"{_HERE}.short_windows:PART",
        "answer_time": f"{_HERE}.answer_time:PART",
        "anytime": f"{_HERE}.anytime:PART",
        "in_force": f"{_HERE}.in_force:PART",
        "generalise": f"{_HERE}.generalise:PART",
        "structure": f"{_HERE}.structure:PART",
        "whole_grasp": f"{_HERE}.whole_grasp:PART",
        "continuum": f"{_HERE}.continuum:PART",
        "random_rigs": f"{_HERE}.random_rigs:PART",
        "closing_speed": f"{_HERE}.random_rigs:SPEED_PART",
        "inference": f"{_HERE}.inference:PART",
    },
    base="firstcontact_lab.study.part:Part",
    instances=True,
)


def chosen_parts(names: Sequence[str]) -> dict[str, Part]:
    """Return the parts with these names, and all parts that they need, by name.

    Without names, return the default parts.
    """
    chosen: set[str] = set()

    def choose(name: str) -> None:
        chosen.add(name)
        for needed in PARTS.find(name).needs:
            choose(needed)

    for name in names or [name for name, part in PARTS.items() if part.by_default]:
        choose(name)
    return {name: part for name, part in PARTS.items() if name in chosen}
