"""``firstcontact export-model``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from firstcontact.cli.choices import one_of
from firstcontact.core import InputError
from firstcontact.export import MODEL_EXPORTERS

if TYPE_CHECKING:
    from firstcontact.core import Dataset


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
        from firstcontact.core import need_for, replacing_folder
        from firstcontact.export import load_trained, small_enough

        exporter = MODEL_EXPORTERS.find(self.to)
        need_for(exporter)
        if self.out.exists() and (not self.out.is_dir() or any(self.out.iterdir())):
            raise InputError(f"{self.out} is there already: name a folder that is empty or new")
        if self.budget_us is not None and not 0.0 < self.budget_us <= 1e6:
            raise InputError("--budget-us must lie between 0 and 1000000")
        trained = load_trained(self.model)
        trained = small_enough(trained, self._pinches(), self.budget_us, exporter.parts)
        with replacing_folder(self.out) as making, MODEL_EXPORTERS.calling(self.to):
            lines = exporter.write(trained, making)
        for line in lines:
            print(line)
        print(f"written to {self.out}")

    def _pinches(self) -> Dataset | None:
        from firstcontact.recording import load_dataset

        if self.data is None:
            return None
        dataset = load_dataset(self.data)
        return dataset.take(~dataset.test)
