"""Export of datasets to other formats, written atomically.

Signals are in their physical units. Positions of contacts count from the first sample of a pinch.
If importers would assume another layout or other fingers, the file states its layout.
"""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import (
    AnyPath,
    Channel,
    ChannelKind,
    Dataset,
    Finger,
    InputError,
    Layout,
    Pinch,
    creating,
)
from firstcontact.recording._checks import (
    LAYOUT,
    SETTINGS,
    UNITS,
    FileSettings,
    is_rounded_away,
    make_layout,
)
from firstcontact.recording._formats import EXPORTERS, Exporter
from firstcontact.recording._labels import ASSUMED_SESSION, CONTACT_COLUMNS, LABEL_COLUMNS

#: Names of columns that are no signals.
_NAMES = {"pinch", "time_s", *SETTINGS, LAYOUT, *LABEL_COLUMNS, *CONTACT_COLUMNS}


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


def table_values(
    dataset: Dataset, channels: Sequence[Channel]
) -> tuple[dict[str, list[Any]], dict[str, Any]]:
    """Return what a file of these channels holds besides samples: per pinch, and per file."""
    of_pinch, of_file = _pinch_values(dataset), _file_values(dataset)
    physical = tuple(replace(c, scale=1.0, offset=0.0) for c in channels)
    layout = Layout(physical, dataset.layout.rate)
    # Importers assume that a finger with a sensor touches first.
    fingers = {p.first.finger for p in dataset.pinches if p.first is not None}
    if not fingers <= set(layout.vibration_fingers) or layout != _assumed_layout(layout):
        of_pinch["first_finger"] = [
            -1 if p.first is None or p.first.finger is None else p.first.finger
            for p in dataset.pinches
        ]
        of_file[LAYOUT] = json.dumps(layout.to_json(), ensure_ascii=False)
    return of_pinch, of_file


def _assumed_layout(layout: Layout) -> Layout | None:
    """Return the layout that importers assume for these channels; None if they know no such."""
    first, *others = layout.vibration
    if first.unit not in UNITS or first.sensor is None:
        return None
    settings = FileSettings(
        first.sensor, layout.rate, first.unit, first.smoothing_alpha, "unknown", first.axis
    )
    return make_layout(
        settings,
        1 + len(others),
        axes=first.axes,
        force=layout.has_force,
        strip=layout.has_strip,
    )


def _pinch_values(dataset: Dataset) -> dict[str, list[Any]]:
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
    if dataset.sessions_assumed and set(values["session"]) == {ASSUMED_SESSION}:
        del values["session"]
    return {name: column for name, column in values.items() if not {None, ""} & set(column)}


def _file_values(dataset: Dataset) -> dict[str, Any]:
    """Return the settings of all pinches, by the names that importers use."""
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
    clashes = sorted(_NAMES & {name.strip() for name in layout.column_names})
    if clashes:
        raise InputError(
            f"the channel {clashes[0]!r} has the name of another column: export to hdf5 or "
            "mcap-plot"
        )
    physical = physical_values(pinch, tuple(range(layout.width)))
    time = (pinch.first_sample + np.arange(len(pinch.data))) / layout.rate
    signals = {name: physical[:, i] for i, name in enumerate(layout.column_names)}
    return {"time_s": time, **signals}


def physical_values(pinch: Pinch, columns: tuple[int, ...]) -> NDArray[np.float32]:
    """Return columns of a pinch in their physical units."""
    channels = pinch.layout.column_channels
    values = pinch.layout.physical(pinch.data, columns)
    is_vibration = [channels[i].kind is ChannelKind.VIBRATION for i in columns]
    if is_rounded_away(values[:, is_vibration]):
        raise InputError(
            "a vibration is too small for 32-bit floats beside its offset: export to mcap-plot"
        )
    return values.astype(np.float32)
