"""Command ``firstcontact export-model``: a model as C or as ONNX."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from firstcontact.cli.options import Option, choice
from firstcontact.export import MODEL_EXPORTERS


@dataclass(frozen=True)
class ExportModel:
    """Write the detector with the network or an SVM as C, or a CNN as ONNX."""

    model: Annotated[Path, Option(positional=True)]
    """Folder that `train` or `adapt` wrote."""
    to: Annotated[str, choice(MODEL_EXPORTERS)]
    """Format of the exported model."""
    out: Path
    """Folder for the files; it must be empty or new."""
    data: Path | None = None
    """Training recordings, to fit smaller forms of the model."""
    budget_us: float | None = None
    """Longest allowed time of a prediction on a 600 MHz Cortex-M7, us."""
    estimator: str | None = None
    """Estimator to export, by default the first one of the model."""

    def run(self) -> None:
        from firstcontact.export import export_model
        from firstcontact.recording import load_dataset

        data = None if self.data is None else load_dataset(self.data)
        lines = export_model(
            self.model,
            self.out,
            to=self.to,
            data=data,
            budget_us=self.budget_us,
            estimator=self.estimator,
        )
        for line in lines:
            print(line)
        print(f"written to {self.out}")
