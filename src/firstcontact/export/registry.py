"""Registry of the formats that trained models are exported to."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from firstcontact.core import Registry

if TYPE_CHECKING:
    from firstcontact.models import Model


@dataclass(frozen=True, slots=True)
class ModelExporter:
    """Exporter of trained models to one file format, such as "onnx"."""

    name: str
    #: Function that writes a model into an empty folder and returns notes.
    write: Callable[[Model, Path], Sequence[str]]
    #: Required extra of this package, and its modules.
    extra: str = ""
    modules: tuple[str, ...] = ()


#: Exporters of trained models by name of the format, including those of plug-ins.
MODEL_EXPORTERS: Registry[ModelExporter] = Registry(
    "form",
    "firstcontact.model_exporters",
    {"c": "firstcontact.export._c_library:C", "onnx": "firstcontact.export._onnx:ONNX"},
    base="firstcontact.export.registry:ModelExporter",
    instances=True,
)
