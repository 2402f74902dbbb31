"""Registry of export formats. To add a format, write one file and add one line here."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from firstcontact.core import Registry

if TYPE_CHECKING:
    from firstcontact.export._trained import Trained


@dataclass(frozen=True, slots=True)
class ModelExporter:
    """Exporter of trained models to one format.

    Parameters
    ----------
    name
        Name in the registry.
    write
        Function that writes the parts of a model into an empty folder and returns notes. It raises
        InputError with the part that cannot be written, and the reason.
    extra, modules
        Required extra of this package, and its modules.
    """

    name: str
    write: Callable[[Trained, Path], Sequence[str]]
    extra: str = ""
    modules: tuple[str, ...] = ()


MODEL_EXPORTERS: Registry[ModelExporter] = Registry(
    "form",
    "firstcontact.model_exporters",
    {
        "c": "firstcontact.export._c_library:C",
        "onnx": "firstcontact.export._onnx_graph:ONNX",
    },
    base="firstcontact.export._exporters:ModelExporter",
    instances=True,
)
