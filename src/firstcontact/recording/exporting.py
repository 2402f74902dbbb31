"""Write a dataset for other tools: CSV and Parquet (a row a sample), HDF5 (arrays).

CSV and HDF5 are what :mod:`firstcontact.recording.importing` reads. Signals
are in their physical units, contacts count from a pinch's first sample.
"""

from __future__ import annotations

import csv
import math
import os
from collections.abc import Callable, Mapping
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from firstcontact.core import ChannelKind, Dataset, Finger, InputError, Layout, Pinch
from firstcontact.core.files import creating
from firstcontact.core.layout import TAXELS

#: Pinches that share a row group of a Parquet file.
_PINCHES_A_GROUP = 50


def export(dataset: Dataset, to: str, out: Path) -> None:
    """Write a dataset as "csv", "parquet" or "hdf5".

    Raises
    ------
    InputError
        The file exists or cannot be written, or HDF5 is asked for pinches of
        different length.
    """
    try:
        with creating(out) as temporary:
            EXPORTERS[to](dataset, temporary)
    except OSError as error:
        if isinstance(error, FileExistsError) and os.path.lexists(out):
            raise InputError(f"{out} exists: choose another --out") from error
        raise InputError(
            f"{out} cannot be written ({error.strerror or error}): check the folder and its disk"
        ) from error


def pinch_values(dataset: Dataset) -> dict[str, list[Any]]:
    """One value a pinch of every label and contact that is known for all of them."""
    pinches = dataset.pinches
    values: dict[str, list[Any]] = {
        "object": [p.label.object for p in pinches],
        "shore_a": [p.label.shore_a for p in pinches],
        "hardness_rank": [p.label.hardness_rank for p in pinches],
        "specimen": [p.label.specimen for p in pinches],
        "session": [p.label.session for p in pinches],
        "role": [str(p.label.role) for p in pinches],
        "first_contact": [
            -1 if p.first is None else p.first.sample - p.first_sample for p in pinches
        ],
        "second_contact": [
            -1 if p.second is None else p.second.sample - p.first_sample for p in pinches
        ],
        "first_finger": [int(Finger.INDEX if p.first is None else p.first.finger) for p in pinches],
    }
    if any(p.motor_start is not None for p in pinches):
        values["motor_start"] = [
            -1 if p.motor_start is None else p.motor_start - p.first_sample for p in pinches
        ]
    return {name: column for name, column in values.items() if not {None, ""} & set(column)}


def file_values(dataset: Dataset) -> dict[str, Any]:
    """What holds for all pinches, under the names that the importers know."""
    layout = dataset.layout
    return {
        "sample_rate_hz": layout.rate,
        "piezo_unit": layout.channels[layout.columns(ChannelKind.PIEZO)[0]].unit,
        "smoothing_alpha": layout.smoothing_alpha,
        "source": dataset.source,
    }


def _export_hdf5(dataset: Dataset, path: Path) -> None:
    import h5py

    lengths = {len(p.data) for p in dataset.pinches}
    if len(lengths) > 1:
        raise InputError(
            f"pinches have {min(lengths)} to {max(lengths)} samples and an HDF5 array needs one "
            "length: export to csv or parquet"
        )
    count, samples = len(dataset), lengths.pop()
    layout = dataset.layout
    shapes: dict[ChannelKind, tuple[int, ...]] = {
        ChannelKind.PIEZO: (count, samples, len(layout.columns(ChannelKind.PIEZO))),
        ChannelKind.FORCE: (count, samples, 2, TAXELS),
        ChannelKind.STRIP: (count, samples, 2),
    }
    columns = {kind: _by_finger(layout, kind) for kind in shapes}
    for kind, shape in shapes.items():
        if columns[kind] and len(columns[kind]) != math.prod(shape[2:]):
            raise InputError(
                f"the fingers have {len(columns[kind])} {kind} channels and an HDF5 array needs "
                f"{math.prod(shape[2:])}: export to csv or parquet"
            )
    # In memory, since the library crashes the process when a disk is full.
    image = BytesIO()
    with h5py.File(image, "w") as file:
        for kind, shape in shapes.items():
            if not columns[kind]:
                continue
            array = file.create_dataset(str(kind), shape, np.float32)
            for i, pinch in enumerate(dataset.pinches):
                array[i] = layout.physical(pinch.data, columns[kind]).reshape(shape[1:])
        for name, column in pinch_values(dataset).items():
            text = isinstance(column[0], str)
            file.create_dataset(name, data=column, dtype=h5py.string_dtype() if text else None)
        file.attrs.update(file_values(dataset))
    with path.open("wb") as stream:
        stream.write(image.getbuffer())


def _by_finger(layout: Layout, kind: ChannelKind) -> tuple[int, ...]:
    """Columns in the order of an array: index, then thumb, taxel by taxel."""
    return tuple(
        column
        for finger in Finger
        for column in sorted(
            layout.columns(kind, finger), key=lambda c: layout.channels[c].taxel or 0
        )
    )


def _rows(pinch: Pinch) -> dict[str, Any]:
    """The columns of a pinch that have a value for every sample."""
    layout = pinch.layout
    physical = layout.physical(pinch.data, tuple(range(len(layout.channels)))).astype(np.float32)
    time = (pinch.first_sample + np.arange(len(pinch.data))) / layout.rate
    signals = {c.name: physical[:, i] for i, c in enumerate(layout.channels)}
    return {"time_s": time, **signals}


def _export_csv(dataset: Dataset, path: Path) -> None:
    of_pinch, of_file = pinch_values(dataset), file_values(dataset)
    with path.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(["pinch", *_rows(dataset.pinches[0]), *of_pinch, *of_file])
        for i, pinch in enumerate(dataset.pinches):
            same = [*(column[i] for column in of_pinch.values()), *of_file.values()]
            time, *signals = _rows(pinch).values()
            for now, *row in zip(time, *signals, strict=True):
                # Nine digits give every float32 back exactly.
                writer.writerow([i, f"{now:.9f}", *(f"{v:.9g}" for v in row), *same])


def _export_parquet(dataset: Dataset, path: Path) -> None:
    import pyarrow as pa
    from pyarrow import parquet

    of_pinch, of_file = pinch_values(dataset), file_values(dataset)

    def table(first: int) -> Any:
        parts = []
        for i, pinch in enumerate(dataset.pinches[first : first + _PINCHES_A_GROUP], first):
            samples = len(pinch.data)
            same = {name: [column[i]] * samples for name, column in of_pinch.items()}
            whole = {name: [value] * samples for name, value in of_file.items()}
            parts.append(pa.table({"pinch": np.full(samples, i), **_rows(pinch), **same, **whole}))
        return pa.concat_tables(parts)

    with parquet.ParquetWriter(path, table(0).schema) as writer:
        for first in range(0, len(dataset), _PINCHES_A_GROUP):
            writer.write_table(table(first))


#: Name of a format to what writes it.
EXPORTERS: Mapping[str, Callable[[Dataset, Path], None]] = {
    "csv": _export_csv,
    "parquet": _export_parquet,
    "hdf5": _export_hdf5,
}
