"""Onsets of the recordings to label, and pieces of their signals for the page."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from firstcontact.collect._label_marks import MOST, Mark
from firstcontact.contact.finder import find_onsets
from firstcontact.core import ChannelKind, InputError, Label, finger_name
from firstcontact.recording import Recording, read_recording
from firstcontact.recording.dataset import find_recordings

#: Largest number of points of a channel in a piece. Longer pieces are reduced to minima and maxima.
POINTS = 2000
#: Greatest length of a piece on either side of its middle, s.
WIDEST = 2.0


def open_recordings(paths: Sequence[Path]) -> list[Recording]:
    """Read all recordings in files and folders. Refuse those without samples."""
    files = [file for path in paths for file in find_recordings(path)]
    names = [file.name for file in files]
    doubled = next((name for name in names if names.count(name) > 1), None)
    if doubled is not None:
        raise InputError(f"two recordings are called {doubled}: label them in separate commands")
    recordings = [read_recording(file) for file in files]
    empty = next((r for r in recordings if not r.samples), None)
    if empty is not None:
        raise InputError(f"{empty.path} holds no samples: leave this recording out")
    return recordings


def find_marks(recordings: Sequence[Recording]) -> list[Mark]:
    """Return all detected onsets. An onset inside a pinch has the label of that pinch."""
    out: list[Mark] = []
    for number, recording in enumerate(recordings):
        layout = recording.header.layout
        columns = layout.columns(ChannelKind.VIBRATION)
        for place, block in enumerate(recording.stretches):
            for onset in find_onsets(layout.physical(block.data, columns), layout.rate):
                at = block.first_sample + onset.sample
                labels = (
                    p.label
                    for p in recording.pinches
                    if p.epoch == block.epoch and p.first_sample <= at < p.end
                )
                label = next(labels, Label())
                mark = Mark(len(out), number, place, onset.column, onset.sample, onset.sample)
                out.append(replace(mark, object=label.object, shore_a=label.shore_a))
    if not out:
        raise InputError(
            f"no contact is found in {', '.join(r.path.name for r in recordings[:3])}"
            f"{' and others' if len(recordings) > 3 else ''}: give recordings with "
            "contacts that are louder than the noise"
        )
    if len(out) > MOST:
        raise InputError(
            f"{recordings[0].path} and the other recordings have {len(out)} onsets, more than "
            f"{MOST}: label them in several commands"
        )
    return out


def about(recordings: Sequence[Recording]) -> list[dict[str, Any]]:
    """Return each recording's name, rate, channels and stretch lengths, for the page."""
    return [
        {
            "name": r.path.name,
            "rate": r.header.layout.rate,
            "channels": [
                {"name": c.name, "finger": finger_name(c.finger), "unit": c.unit}
                for c in r.header.layout.vibration
            ],
            "lengths": [len(s.data) for s in r.stretches],
        }
        for r in recordings
    ]


def piece(recording: Recording, stretch: int, middle: int, half: float) -> dict[str, Any]:
    """Return all vibration signals around one sample, reduced to minima and maxima for a plot."""
    layout = recording.header.layout
    block = recording.stretches[stretch]
    reach = max(1, round(min(half, WIDEST) * layout.rate))
    first, end = max(0, middle - reach), min(len(block.data), middle + reach + 1)
    values = layout.physical(block.data[first:end], layout.columns(ChannelKind.VIBRATION))
    step = max(1, -(-len(values) // POINTS))
    edges = np.arange(0, len(values), step)
    least, most = np.minimum.reduceat(values, edges), np.maximum.reduceat(values, edges)
    return {"first": first, "step": step, "least": _rounded(least), "most": _rounded(most)}


def _rounded(values: np.ndarray) -> list[list[float]]:
    """Return six significant digits of each channel's values."""
    return [[float(f"{v:.6g}") for v in column] for column in values.T.tolist()]
