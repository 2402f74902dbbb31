"""``firstcontact export-model``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from firstcontact.cli.choices import one_of
from firstcontact.core.errors import InputError
from firstcontact.embedded.exporters import MODEL_EXPORTERS


@dataclass(frozen=True)
class ExportModel:
    """Write a trained model in another language: C for the hand's microcontroller, or ONNX."""

    model: tyro.conf.Positional[Path]
    """Folder that ``train`` or ``adapt`` wrote."""
    to: Annotated[str, one_of(MODEL_EXPORTERS)]
    """Form."""
    out: Path
    """Folder for it; must be empty or new."""

    def run(self) -> None:
        """Export whole, or not at all."""
        from firstcontact.core.extras import need
        from firstcontact.core.folders import replacing_folder
        from firstcontact.embedded.trained import load_trained

        exporter = MODEL_EXPORTERS.find(self.to)
        need(exporter.extra, *exporter.modules)
        if self.out.exists() and (not self.out.is_dir() or any(self.out.iterdir())):
            raise InputError(f"{self.out} is there already: name a folder that is empty or new")
        trained = load_trained(self.model)
        with replacing_folder(self.out) as making:
            lines = exporter.write(trained, making)
        for line in lines:
            print(line)
        print(f"written to {self.out}")
