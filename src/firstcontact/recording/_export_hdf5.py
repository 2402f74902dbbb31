"""Exporter to arrays in HDF5; :mod:`firstcontact.recording._arrays` reads them."""

from __future__ import annotations

import math
from io import BytesIO
from pathlib import Path

import numpy as np

from firstcontact.core import TAXELS, ChannelKind, Dataset, InputError, Layout
from firstcontact.recording._exporting import physical_values, table_values
from firstcontact.recording._formats import Exporter


def _write(dataset: Dataset, path: Path) -> None:
    import h5py

    lengths = {len(p.data) for p in dataset.pinches}
    if len(lengths) > 1:
        raise InputError(
            f"pinches have {min(lengths)} to {max(lengths)} samples and an HDF5 array needs one "
            "length: export to csv or parquet"
        )
    count, samples = len(dataset), lengths.pop()
    layout = dataset.layout
    sensor, axes = str(layout.vibration[0].sensor), layout.vibration[0].axes
    shapes: dict[ChannelKind, tuple[int, ...]] = {
        ChannelKind.VIBRATION: (
            count,
            samples,
            min(2, len(layout.vibration)),
            *([axes] if axes > 1 else []),
        ),
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
    all_channels = layout.column_channels
    channels = dict.fromkeys(all_channels[i] for kind in shapes for i in columns[kind])
    values, settings = table_values(dataset, list(channels))
    for name, column in values.items():
        if any(isinstance(value, str) and "\0" in value for value in column):
            raise InputError(
                f"{name} of a pinch has a character 0, which no text in HDF5 can have: export to "
                "csv or parquet"
            )
    # The file is built in memory, because the library crashes the process on a full disk.
    image = BytesIO()
    with h5py.File(image, "w") as file:
        for kind, shape in shapes.items():
            if not columns[kind]:
                continue
            array = file.create_dataset(
                sensor if kind is ChannelKind.VIBRATION else kind, shape, np.float32
            )
            for i, pinch in enumerate(dataset.pinches):
                array[i] = physical_values(pinch, columns[kind]).reshape(shape[1:])
        for name, column in values.items():
            text = isinstance(column[0], str)
            file.create_dataset(name, data=column, dtype=h5py.string_dtype() if text else None)
        file.attrs.update(settings)
    with path.open("wb") as stream:
        stream.write(image.getbuffer())


def _by_finger(layout: Layout, kind: ChannelKind) -> tuple[int, ...]:
    """Return the columns of one kind in the order of an array: by finger, then by taxel or axis."""
    columns = [(c, i) for i, c in enumerate(layout.column_channels) if c.kind is kind]
    return tuple(
        i for _, i in sorted(columns, key=lambda ci: (ci[0].finger or 0, ci[0].taxel or 0))
    )


HDF5 = Exporter("hdf5", _write)
