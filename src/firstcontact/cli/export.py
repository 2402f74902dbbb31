"""``firstcontact export``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import tyro


@dataclass(frozen=True)
class Export:
    """Write the pinches of recordings for other tools."""

    path: tyro.conf.Positional[Path]
    """A recording, or a folder of them."""
    to: Literal["csv", "parquet", "hdf5"]
    """Format: a row a sample (csv, parquet) or arrays (hdf5)."""
    out: Path
    """The new file."""

    def run(self) -> None:
        """Export, and say what was left out."""
        from firstcontact.core.extras import need
        from firstcontact.recording import load_dataset
        from firstcontact.recording.exporting import export

        if self.to == "parquet":
            need("parquet", "pyarrow")
        dataset = load_dataset(self.path)
        export(dataset, self.to, self.out)
        for note in dataset.notes:
            print(f"note: {note}")
        print(f"{len(dataset)} pinches written to {self.out}")
