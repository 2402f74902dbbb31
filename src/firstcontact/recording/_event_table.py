"""Contacts in long files, from a CSV (one row per contact) or an Audacity label track.

A CSV has ``onset_s`` (seconds from the start of the file) or ``onset_sample`` (from 0). ``file`` is
needed if there are several files, ``channel`` (from 0) to choose one channel. The table may also
have any of the labels of :mod:`firstcontact.recording._labels`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import InputError
from firstcontact.recording import _cells as cells
from firstcontact.recording._label_track import ONSET, is_track, read_track
from firstcontact.recording._labels import CONTACT_COLUMNS, LABEL_COLUMNS
from firstcontact.recording._quoting import quote
from firstcontact.recording._table import Table, read_columns
from firstcontact.recording._table_columns import unknown_columns

#: Time before and after a contact that a pinch includes, s: quiet for the detector's noise, and a
#: window with the look-ahead of filters. Closer contacts share the time between them.
BEFORE, AFTER = 0.080, 0.060
SECONDS, SAMPLE = ONSET, "onset_sample"
CHANNEL = "channel"
_FINGER = "first_finger"
_KNOWN = {"file", CHANNEL, SECONDS, SAMPLE, _FINGER, "source", "comment", *LABEL_COLUMNS}

Columns = Table


@dataclass(frozen=True, slots=True)
class Event:
    """Contact in a long file, with its table row, file number, channel (if named) and sample."""

    row: int
    file: int
    channel: int | None
    sample: int


def read_event_table(table: Path) -> Columns:
    """Read the columns of a CSV or label track."""
    columns = read_track(table) if is_track(table) else read_columns(table)
    for name in CONTACT_COLUMNS:
        if name in columns and name != _FINGER:
            raise InputError(
                f"{table} has a column '{name}', which is relative to the start of a pinch: give "
                f"each contact from the start of the file, as a time in a column '{SECONDS}' or "
                f"as a sample's number in a column '{SAMPLE}'"
            )
    return columns


def find_events(
    table: Path,
    columns: Columns,
    of_rows: Sequence[int | None],
    files: Sequence[Path],
    shapes: Sequence[tuple[int, ...]],
    rates: Sequence[float],
) -> list[Event]:
    """Return the contacts in the order of the rows."""
    given = [name for name in (SECONDS, SAMPLE) if name in columns]
    if len(given) != 1:
        raise InputError(
            f"{table} has {' and '.join(given) or f'neither {SECONDS} nor {SAMPLE}'}: give each "
            f"contact either its time in a column '{SECONDS}' or its sample's number in a column "
            f"'{SAMPLE}'"
        )
    (name,) = given
    of = cells.each(str(table), columns, CHANNEL, cells.integer)
    out = []
    for row, cell in enumerate(columns[name]):
        file = of_rows[row] if of_rows else 0
        if file is None:
            continue
        try:
            value = cells.number(cell)
        except ValueError as error:
            raise InputError(
                f"{table}: '{name}' of {columns.place(row)} is {quote(cell)}, {error}: correct it"
            ) from None
        rate = rates[file]
        at = value * rate if name == SECONDS else value
        end, channels = shapes[file]
        if of is not None and not 0 <= of[row] < channels:
            raise InputError(
                f"{table}: 'channel' of {columns.place(row)} is {quote(of[row])}, but "
                f"{files[file].name} has {channels}: give the channel's number, counted from 0"
            )
        if not 0 <= at <= end - 1:
            last = f"{(end - 1) / rate:g} s" if name == SECONDS else end - 1
            raise InputError(
                f"{table}: '{name}' of {columns.place(row)} is {quote(cell)}, outside "
                f"{files[file].name} (0 to {last}): correct the row"
            )
        if name == SAMPLE and at != int(at):
            raise InputError(
                f"{table}: '{name}' of {columns.place(row)} is {quote(cell)}, which is not a "
                f"whole number: give samples' numbers, or seconds in the column '{SECONDS}'"
            )
        out.append(Event(row, file, None if of is None else of[row], round(at)))
    for one, other in pairwise(sorted(out, key=_place)):
        if (one.file, one.sample) == (other.file, other.sample):
            raise InputError(
                f"{table}: {columns.place(one.row)} and {columns.place(other.row)} are the same "
                f"contact, at sample {one.sample} of {files[one.file].name}: remove one"
            )
    return out


def event_labels(
    table: Path, columns: Columns, events: Sequence[Event], starts: Sequence[int]
) -> tuple[Columns, list[str]]:
    """Return the labels of each event, and notes. ``starts`` has the first sample of each pinch."""
    given = {
        name: [cell[event.row] for event in events]
        for name, cell in columns.items()
        if name in (*LABEL_COLUMNS, _FINGER)
    }
    given["first_contact"] = [
        str(event.sample - start) for event, start in zip(events, starts, strict=True)
    ]
    rows = [event.row for event in events]
    return columns.of_rows(given, rows), unknown_columns(table, columns, _KNOWN)


def spans(
    events: Sequence[Event], lengths: Sequence[int], rate: float
) -> tuple[list[int], list[int]]:
    """Return the first samples and the ends of the pinches to cut out around each contact.

    Parameters
    ----------
    events
        Contacts.
    lengths
        Number of samples of each file.
    rate
        Sampling rate, Hz.
    """
    lead, tail = round(BEFORE * rate), round(AFTER * rate)
    starts = [max(0, event.sample - lead) for event in events]
    stops = [min(lengths[event.file], event.sample + tail) for event in events]
    for one, other in pairwise(sorted(range(len(events)), key=lambda i: _place(events[i]))):
        if events[one].file == events[other].file:
            border = _border(events[one].sample, events[other].sample)
            stops[one] = min(stops[one], border)
            starts[other] = max(starts[other], border)
    return starts, stops


def cut_events(
    events: Sequence[Event], recordings: Sequence[NDArray[Any]], rate: float
) -> tuple[list[NDArray[Any]], list[int]]:
    """Return the samples around each contact, and the position of the first of them in the file."""
    starts, stops = spans(events, [len(data) for data in recordings], rate)
    cuts = []
    for event, start, stop in zip(events, starts, stops, strict=True):
        wanted = slice(None) if event.channel is None else slice(event.channel, event.channel + 1)
        cuts.append(np.ascontiguousarray(recordings[event.file][start:stop, wanted]))
    return cuts, starts


def _place(event: Event) -> tuple[int, int]:
    return event.file, event.sample


def _border(one: int, other: int) -> int:
    """Return the sample at which the pinch of one contact ends and the pinch of the next begins."""
    return min(other, one + max(1, round((other - one) * AFTER / (BEFORE + AFTER))))
