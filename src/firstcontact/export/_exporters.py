"""Registry of export forms; a new form is one file and one line here."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING

from firstcontact.core import Registry

if TYPE_CHECKING:
    from firstcontact.export._trained import Trained


class Part(Enum):
    """Part of a training that export can make smaller."""

    WINDOWS = "models of a window"
    ANYTIME = "the network"


@dataclass(frozen=True, slots=True)
class ModelExporter:
    """Export form of trained models.

    Parameters
    ----------
    name
        Under which it is registered.
    write
        Writes a training into a folder that is empty; gives what there is to say. Raises
        InputError naming what cannot be written, and why.
    parts
        What it writes of what can be made smaller; the rest is held to no budget.
    extra, modules
        Of this package that it needs, and the modules that come with it.
    """

    name: str
    write: Callable[[Trained, Path], Sequence[str]]
    parts: frozenset[Part] = frozenset(Part)
    extra: str = ""
    modules: tuple[str, ...] = ()


MODEL_EXPORTERS: Registry[ModelExporter] = Registry(
    "form",
    "firstcontact.model_exporters",
    {
        "c": "firstcontact.export._c_library:C",
        "onnx": "firstcontact.export._onnx_graph:ONNX",
        "hand": "firstcontact.export._hand_model:HAND",
    },
    base="firstcontact.export._exporters:ModelExporter",
    instances=True,
)
