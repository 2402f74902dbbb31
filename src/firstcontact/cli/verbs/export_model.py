"""``firstcontact export-model``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from firstcontact.cli.choices import one_of
from firstcontact.export import MODEL_EXPORTERS


@dataclass(frozen=True)
class ExportModel:
    """Write a trained model as C, as ONNX, or as what a hand is flashed with."""

    model: tyro.conf.Positional[Path]
    """Folder that ``train`` or ``adapt`` wrote."""
    to: Annotated[str, one_of(MODEL_EXPORTERS)]
    """Form."""
    out: Path
    """Folder for it; must be empty or new."""
    data: Path | None = None
    """Recordings that it learned from, to which what is made smaller is fitted: the any-time
    network always is, models of windows where they take longer than the budget."""
    budget_us: float | None = None
    """Time that an answer may take on a Cortex-M7 of 600 MHz, us, at 1.5 cycles an instruction;
    the costliest form that keeps to it is taken."""

    def run(self) -> None:
        """Export whole, or not at all."""
        from firstcontact.export import export_model
        from firstcontact.recording import load_dataset

        data = None if self.data is None else load_dataset(self.data)
        lines = export_model(self.model, self.out, to=self.to, data=data, budget_us=self.budget_us)
        for line in lines:
            print(line)
        print(f"written to {self.out}")
