"""Export of datasets to other formats, written atomically.

Signals are in their physical units. Positions of contacts count from the first sample of a pinch.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np

from firstcontact.core import AnyPath, Dataset, Finger, InputError, Pinch, creating
from firstcontact.recording._formats import EXPORTERS, Exporter


def export(dataset: Dataset, to: Exporter, out: AnyPath) -> None:
    """Write a dataset in another format.

    Raises
    ------
    InputError
        The file exists or cannot be written, or the format cannot hold the dataset.
    """
    out = Path(out)
    try:
        with creating(out) as temporary, EXPORTERS.calling(to.name):
            to.write(dataset, temporary)
    except OSError as error:
        if isinstance(error, FileExistsError) and os.path.lexists(out):
            raise InputError(f"{out} exists: choose another --out") from error
        raise InputError(
            f"{out} cannot be written ({error.strerror or error}): check the folder and its disk"
        ) from error


def pinch_values(dataset: Dataset) -> dict[str, list[Any]]:
    """Return each label and contact that all pinches have, with one value per pinch."""
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
        "first_finger": [
            Finger.INDEX.value if p.first is None else p.first.finger for p in pinches
        ],
    }
    if any(p.motor_start is not None for p in pinches):
        values["motor_start"] = [
            -1 if p.motor_start is None else p.motor_start - p.first_sample for p in pinches
        ]
    if any(p.closing_speed is not None for p in pinches):
        speeds = [p.closing_speed for p in pinches]
        values["closing_speed"] = [-1.0 if s is None else s.speed for s in speeds]
        values["closing_speed_error"] = [-1.0 if s is None else s.error for s in speeds]
    return {name: column for name, column in values.items() if not {None, ""} & set(column)}


def file_values(dataset: Dataset) -> dict[str, Any]:
    """Return the settings of all pinches, by the names that importers use.

    Raises
    ------
    InputError
        The vibration channels differ in a setting.
    """
    layout = dataset.layout
    first, *second = layout.vibration
    for name in ("sensor", "unit", "smoothing_alpha", "axes", "axis"):
        if any(getattr(c, name) != getattr(first, name) for c in second):
            raise InputError(
                f"the vibration channels differ in {name}, but the format holds one value for "
                "both: export to mcap-plot"
            )
    return {
        "sample_rate_hz": layout.rate,
        f"{first.sensor}_unit": first.unit,
        "smoothing_alpha": first.smoothing_alpha,
        "source": dataset.source,
        **({"axis": first.axis} if first.axes > 1 else {}),
    }


def sample_values(pinch: Pinch) -> dict[str, Any]:
    """Return the time and the signals of a pinch by name, with one value per sample."""
    layout = pinch.layout
    physical = layout.physical(pinch.data, tuple(range(layout.width))).astype(np.float32)
    time = (pinch.first_sample + np.arange(len(pinch.data))) / layout.rate
    signals = {name: physical[:, i] for i, name in enumerate(layout.column_names)}
    return {"time_s": time, **signals}
