"""Exporter to a CSV with one row per sample; :mod:`firstcontact.recording._csv` reads it."""

from __future__ import annotations

import csv
from pathlib import Path

from firstcontact.core import Dataset
from firstcontact.recording._checks import LAYOUT
from firstcontact.recording._exporting import sample_values, table_values
from firstcontact.recording._formats import Exporter


def _write(dataset: Dataset, path: Path) -> None:
    of_pinch, of_file = table_values(dataset, dataset.layout.channels)
    # Long, so only once in each pinch.
    layout = {LAYOUT: of_file.pop(LAYOUT)} if LAYOUT in of_file else {}
    with path.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(["pinch", *sample_values(dataset.pinches[0]), *of_pinch, *of_file, *layout])
        for i, pinch in enumerate(dataset.pinches):
            same = [*(column[i] for column in of_pinch.values()), *of_file.values()]
            once = [*layout.values()]
            time, *signals = sample_values(pinch).values()
            for now, *row in zip(time, *signals, strict=True):
                # Nine digits restore every float32 exactly.
                writer.writerow([i, f"{now:.9f}", *(f"{v:.9g}" for v in row), *same, *once])
                once = [""] * len(layout)


CSV = Exporter("csv", _write)
