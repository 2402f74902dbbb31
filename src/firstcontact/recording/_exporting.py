"""Export of datasets to CSV, Parquet and HDF5, written atomically.

Signals are in their physical units. Positions of contacts count from the first sample of a pinch.
The file states its layout, so that importers restore it exactly.
"""

from __future__ import annotations

import csv
import json
import math
import os
from collections.abc import Sequence
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Channel, ChannelKind, Dataset, FileError, Layout, Pinch
from firstcontact.core.files import AnyPath, creating
from firstcontact.core.layout import TAXELS
from firstcontact.core.quantity import QUANTITIES
from firstcontact.recording._formats import EXPORTERS, Exporter
from firstcontact.recording._labels import ASSUMED_SESSION, PINCH_COLUMNS
from firstcontact.recording.settings import LAYOUT, SETTINGS, is_rounded_away

#: Names of columns that are no signals.
_NAMES = {"pinch", "time_s", *SETTINGS, LAYOUT, *PINCH_COLUMNS}


def export(dataset: Dataset, to: Exporter, out: AnyPath) -> None:
    """Write a dataset to the new file ``out`` in the format ``to``, such as ``EXPORTERS["csv"]``.

    Raises
    ------
    InputError
        The file exists or cannot be written, or the format cannot store the dataset.
    """
    out = Path(out)
    try:
        with creating(out) as temporary, EXPORTERS.convert_errors(to.name):
            to.write(dataset, temporary)
    except OSError as error:
        if isinstance(error, FileExistsError) and os.path.lexists(out):
            raise FileError(f"{out} exists: choose another path") from error
        raise FileError(
            f"{out} cannot be written ({error.strerror or error}): check the folder and its disk"
        ) from error


def _write_csv(dataset: Dataset, path: Path) -> None:
    of_pinch, of_file = _export_values(dataset, dataset.layout.channels)
    layout = of_file.pop(LAYOUT)  # long, so only once in each pinch
    with path.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(
            ["pinch", *_signals_by_column(dataset.pinches[0]), *of_pinch, *of_file, LAYOUT]
        )
        for i, pinch in enumerate(dataset.pinches):
            same = [*(column[i] for column in of_pinch.values()), *of_file.values()]
            once = layout
            time, *signals = _signals_by_column(pinch).values()
            for now, *row in zip(time, *signals, strict=True):
                # Nine digits restore every float32 exactly.
                writer.writerow([i, f"{now:.9f}", *(f"{v:.9g}" for v in row), *same, once])
                once = ""


def _write_parquet(dataset: Dataset, path: Path) -> None:
    import pyarrow as pa
    from pyarrow import parquet

    of_pinch, of_file = _export_values(dataset, dataset.layout.channels)
    of_file.pop(LAYOUT)  # no importer reads it here

    def table(i: int) -> Any:
        labels = {**{name: column[i] for name, column in of_pinch.items()}, **of_file}
        count = len(dataset[i].data)
        repeated = {name: [value] * count for name, value in labels.items()}
        return pa.table({"pinch": np.full(count, i), **_signals_by_column(dataset[i]), **repeated})

    with parquet.ParquetWriter(path, table(0).schema) as writer:
        for i in range(len(dataset)):
            writer.write_table(table(i))


def _write_hdf5(dataset: Dataset, path: Path) -> None:
    import h5py

    remedy = "export to csv or parquet"
    lengths = {len(p.data) for p in dataset.pinches}
    if len(lengths) > 1:
        raise FileError(
            f"the pinches have {min(lengths)} to {max(lengths)} samples, but an HDF5 array needs "
            f"equal lengths: {remedy}"
        )
    layout, count = dataset.layout, len(dataset)
    first = layout.vibration[0]
    vectors = (first.axes,) if first.axes > 1 else ()
    shapes: dict[ChannelKind, tuple[int, ...]] = {
        ChannelKind.VIBRATION: (min(2, len(layout.vibration)), *vectors),
        ChannelKind.FORCE: (2, TAXELS),
        ChannelKind.STRIP: (2,),
    }
    columns = {kind: _columns_by_finger(layout, kind) for kind in shapes}
    for kind, shape in shapes.items():
        if columns[kind] and len(columns[kind]) != math.prod(shape):
            raise FileError(
                f"the dataset has {len(columns[kind])} {kind} channels, but an HDF5 array needs "
                f"{math.prod(shape)}: {remedy}"
            )
    channels = layout.column_channels
    ordered = dict.fromkeys(channels[i] for kind in shapes for i in columns[kind])
    of_pinch, of_file = _export_values(dataset, list(ordered))
    # The file is built in memory, because the library crashes the process on a full disk.
    image = BytesIO()
    with h5py.File(image, "w") as file:
        for kind, shape in shapes.items():
            if columns[kind]:
                name = str(first.sensor) if kind is ChannelKind.VIBRATION else kind
                size = (count, *lengths, *shape)
                array = file.create_dataset(name, size, np.float32)
                for i, pinch in enumerate(dataset.pinches):
                    array[i] = _physical(pinch, columns[kind]).reshape(size[1:])
        for name, column in of_pinch.items():
            is_text = isinstance(column[0], str)
            if is_text and any("\0" in text for text in column):
                raise FileError(
                    f"{name} of a pinch contains a zero byte, which HDF5 cannot store: {remedy}"
                )
            file.create_dataset(name, data=column, dtype=h5py.string_dtype() if is_text else None)
        for name in dict.fromkeys(name for pinch in dataset for name in pinch.groups):
            parts = [p.group(name) if name in p.groups else (np.zeros(0),) * 2 for p in dataset]
            file[f"groups/{name}/time_s"] = _stack_padded([times for times, _ in parts])
            file[f"groups/{name}/values"] = _stack_padded([values for _, values in parts])
        file.attrs.update(of_file)
    path.write_bytes(image.getbuffer())


def _stack_padded(parts: Sequence[NDArray[np.float64]]) -> NDArray[np.float64]:
    """Stack arrays of different lengths into one array. Fill up shorter arrays with NaN."""
    longest = max(parts, key=len)
    out = np.full((len(parts), *longest.shape), math.nan)
    for row, part in zip(out, parts, strict=True):
        row[: len(part)] = part
    return out


def _columns_by_finger(layout: Layout, kind: ChannelKind) -> tuple[int, ...]:
    """Return the column numbers of one kind of channel, sorted by finger, then by taxel or axis."""
    channels = layout.column_channels
    columns = [i for i, channel in enumerate(channels) if channel.kind is kind]
    columns.sort(key=lambda i: (channels[i].finger or 0, channels[i].taxel or 0))
    return tuple(columns)


def _export_values(
    dataset: Dataset, channels: Sequence[Channel]
) -> tuple[dict[str, list[Any]], dict[str, Any]]:
    """Return what an export holds beside the samples, as two dicts by name.

    The first dict has lists with one value per pinch, and the second dict has the settings of the
    file. One setting is the layout of ``channels``, whose signals are exported in physical units.
    """
    physical = tuple(replace(c, scale=1.0, offset=0.0) for c in channels)
    layout = Layout(physical, dataset.layout.rate)
    text = json.dumps(layout.to_json(), ensure_ascii=False)
    return _pinch_values(dataset), {**_file_settings(dataset), LAYOUT: text}


def _pinch_values(dataset: Dataset) -> dict[str, list[Any]]:
    """Return labels and contacts as lists by column name, with one value per pinch.

    An unknown contact or speed is -1. A column of labels with an unknown value is left out. The
    samples of contacts are counted from the first sample of the pinch.
    """
    pinches = dataset.pinches

    def places(samples: Sequence[int | None]) -> list[int]:
        pairs = zip(samples, pinches, strict=True)
        return [-1 if at is None else at - pinch.first_sample for at, pinch in pairs]

    values: dict[str, list[Any]] = {
        name: [getattr(p.label, name) for p in pinches]
        for name in ("object", *QUANTITIES, "specimen", "session", "role")
    }
    values["role"] = [str(role) for role in values["role"]]
    values["first_contact"] = places([p.first.sample if p.first else None for p in pinches])
    values["second_contact"] = places([p.second.sample if p.second else None for p in pinches])
    values["first_finger"] = [
        -1 if p.first is None or p.first.finger is None else p.first.finger for p in pinches
    ]
    if any(p.label.shape for p in pinches):
        values["shape"] = [p.label.shape or "-1" for p in pinches]
    if any(p.motor_start is not None for p in pinches):
        values["motor_start"] = places([p.motor_start for p in pinches])
    if any(p.closing_speed is not None for p in pinches):
        speeds = [p.closing_speed for p in pinches]
        values["closing_speed"] = [-1.0 if s is None else s.speed for s in speeds]
        values["closing_speed_error"] = [-1.0 if s is None else s.error for s in speeds]
    if dataset.sessions_assumed and set(values["session"]) == {ASSUMED_SESSION}:
        del values["session"]
    return {name: column for name, column in values.items() if not {None, ""} & set(column)}


def _file_settings(dataset: Dataset) -> dict[str, Any]:
    """Return the settings that all pinches share, such as the rate.

    The keys are the names that the importers read. Raises FileError if the vibration channels
    differ in such a setting.
    """
    first, *others = dataset.layout.vibration
    for name in ("sensor", "unit", "smoothing_alpha", "axes", "axis"):
        if any(getattr(c, name) != getattr(first, name) for c in others):
            raise FileError(
                f"the vibration channels differ in {name!r}, but the format stores one value for "
                "all: export to mcap-plot"
            )
    return {
        "sample_rate_hz": dataset.layout.rate,
        f"{first.sensor}_unit": first.unit,
        "smoothing_alpha": first.smoothing_alpha,
        "source": dataset.source,
        **({"axis": first.axis} if first.axes > 1 else {}),
    }


def _signals_by_column(pinch: Pinch) -> dict[str, Any]:
    """Return the columns of a pinch by name: the times, s, and the signals in physical units.

    Raises FileError if the name of a channel is also that of another column.
    """
    names = pinch.layout.column_names
    clashes = sorted(_NAMES & set(map(str.strip, names)))
    if clashes:
        raise FileError(
            f"the channel {clashes[0]!r} has the name of another column in the file: export to "
            "hdf5 or mcap-plot"
        )
    physical = _physical(pinch, tuple(range(pinch.layout.width)))
    time = (pinch.first_sample + np.arange(len(pinch.data))) / pinch.layout.rate
    return {"time_s": time, **dict(zip(names, physical.T, strict=True))}


def _physical(pinch: Pinch, columns: tuple[int, ...]) -> NDArray[np.float32]:
    channels = pinch.layout.column_channels
    values = pinch.layout.physical(pinch.data, columns)
    is_vibration = [channels[i].kind is ChannelKind.VIBRATION for i in columns]
    if is_rounded_away([values[:, is_vibration]]):
        raise FileError(
            "32-bit floats cannot store a vibration that is so small compared with its offset: "
            "export to mcap-plot"
        )
    return values.astype(np.float32)


CSV = Exporter("csv", _write_csv)
PARQUET = Exporter("parquet", _write_parquet, extra="parquet", modules=("pyarrow",))
HDF5 = Exporter("hdf5", _write_hdf5, extra="files", modules=("h5py",), groups=True)
