"""Command ``firstcontact export``: pinches in the formats of other tools."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from firstcontact.cli.options import Option, choice
from firstcontact.core.text import counted
from firstcontact.recording import EXPORTERS


@dataclass(frozen=True)
class Export:
    """Write the pinches of recordings for other tools."""

    path: Annotated[Path, Option(positional=True)]
    """A recording, or a folder of them."""
    to: Annotated[str, choice(EXPORTERS)]
    """Format of the file; tables have one row per sample."""
    out: Path
    """Path of the new file."""

    def run(self) -> None:
        from firstcontact.core.installation import require_extra
        from firstcontact.recording import export, load_dataset

        exporter = EXPORTERS.find(self.to)
        require_extra(exporter)
        dataset = load_dataset(self.path)
        export(dataset, exporter, self.out)
        for group in () if exporter.groups else dataset.layout.groups:
            print(
                f"note: the samples of group {group.name} are left out, because this format has "
                "only one sampling rate"
            )
        for note in dataset.notes:
            print(f"note: {note}")
        print(f"{counted(len(dataset), 'pinch')} written to {self.out}")
