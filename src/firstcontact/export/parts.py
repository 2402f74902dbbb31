"""Parts of a model that are exported, and the registry of export formats."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from firstcontact.core import Registry

if TYPE_CHECKING:
    from firstcontact.contact import Detector
    from firstcontact.models import AnytimeModel, Interval, Model, WindowModel


@dataclass(frozen=True, slots=True, eq=False)
class NamedModel:
    """Window model with its interval and its name in C, an identifier."""

    name: str
    model: WindowModel
    interval: Interval | None


@dataclass(frozen=True, slots=True, eq=False)
class Trained:
    """Exported parts of a model: window models, the shortest window first, detector and network."""

    models: tuple[NamedModel, ...] = ()
    detector: Detector | None = None
    anytime: AnytimeModel | None = None

    @property
    def rate(self) -> float | None:
        """Sampling rate of the models, Hz; None without models."""
        if self.models:
            return self.models[0].model.spec.rate
        return None if self.anytime is None else self.anytime.rate

    @property
    def has_chain(self) -> bool:
        """True if there is a detector or a network."""
        return self.detector is not None or self.anytime is not None

    @property
    def parts(self) -> list[str]:
        """Descriptions of the parts, one for each."""
        descriptions = [f"{m.name}: {m.model.name}, {m.model.spec.task}" for m in self.models]
        if self.detector is not None:
            descriptions.append(f"detector: {self.detector.name}")
        return descriptions + ([] if self.anytime is None else [f"anytime: {self.anytime.name}"])


def exported_parts(model: Model) -> Trained:
    """Return the parts of a model that are exported."""
    models = tuple(
        NamedModel(
            "stiffness" + ("" if len(model.windows) == 1 else _length(window.duration)),
            window.model,
            window.interval,
        )
        for window in model.windows
    )
    return Trained(models, model.detector, model.anytime)


def _length(duration: float) -> str:
    """Return the suffix of a model's name for a window's length, s: 0.0075 becomes "_07_5ms"."""
    digits, dot, decimals = f"{1e3 * duration:.6g}".partition(".")
    return f"_{digits:0>2}{dot and '_'}{decimals}ms"


@dataclass(frozen=True, slots=True)
class ModelExporter:
    """Exporter of trained models to one format."""

    name: str
    #: Function that writes the parts of a model into an empty folder and returns notes.
    write: Callable[[Trained, Path], Sequence[str]]
    #: Required extra of this package, and its modules.
    extra: str = ""
    modules: tuple[str, ...] = ()


#: Exporters of trained models by name of the format, including those of plug-ins.
MODEL_EXPORTERS: Registry[ModelExporter] = Registry(
    "form",
    "firstcontact.model_exporters",
    {"c": "firstcontact.export._c_library:C", "onnx": "firstcontact.export._onnx:ONNX"},
    base="firstcontact.export.parts:ModelExporter",
    instances=True,
)
