"""Exporter to a Parquet file with one row per sample."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from firstcontact.core import Dataset
from firstcontact.recording._checks import LAYOUT
from firstcontact.recording._exporting import sample_values, table_values
from firstcontact.recording._formats import Exporter

#: Number of pinches per row group.
_PINCHES_A_GROUP = 50


def _write(dataset: Dataset, path: Path) -> None:
    import pyarrow as pa
    from pyarrow import parquet

    of_pinch, of_file = table_values(dataset, dataset.layout.channels)
    of_file.pop(LAYOUT, None)  # no importer reads it here

    def table(first: int) -> Any:
        parts = []
        for i, pinch in enumerate(dataset.pinches[first : first + _PINCHES_A_GROUP], first):
            samples = len(pinch.data)
            same = {name: [column[i]] * samples for name, column in of_pinch.items()}
            constants = {name: [value] * samples for name, value in of_file.items()}
            parts.append(
                pa.table(
                    {"pinch": np.full(samples, i), **sample_values(pinch), **same, **constants}
                )
            )
        return pa.concat_tables(parts)

    with parquet.ParquetWriter(path, table(0).schema) as writer:
        for first in range(0, len(dataset), _PINCHES_A_GROUP):
            writer.write_table(table(first))


PARQUET = Exporter("parquet", _write, extra="parquet", modules=("pyarrow",))
