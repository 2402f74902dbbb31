r"""Contacts in long files, from a CSV (one row per contact) or an Audacity label track.

A CSV has ``onset_s`` (seconds from the start of the file) or ``onset_sample`` (from 0), and
optionally ``file``, ``channel`` (from 0) and labels.

A label track (.txt) has one line ``start<TAB>end<TAB>text`` per label, in seconds. The text of a
label (or of an XDF marker) is the name of the object, or ``name=value`` for any column of labels.
Semicolons separate several labels: ``eraser; shore_a=40``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from firstcontact.core import FileError
from firstcontact.core.files import read_regular
from firstcontact.core.text import parse_float
from firstcontact.recording._labels import (
    CONTACT_COLUMNS,
    LABEL_COLUMNS,
    note_unknown,
    parse_number,
    parse_whole,
)
from firstcontact.recording.table import Table, read_columns
from firstcontact.recording.untrusted import library_errors, quote

#: Time before and after a contact that a pinch includes, s: quiet for the detector's noise, and a
#: window with the look-ahead of filters. Closer contacts share the time between them.
BEFORE, AFTER = 0.080, 0.060
SECONDS, SAMPLE, CHANNEL = "onset_s", "onset_sample", "channel"
#: Note about a file without a table of contacts.
NO_CONTACTS = (
    "no contacts are known: import with `find` to cut long files at the contacts found, list the "
    "contacts in a table of events, or mark them with `firstcontact label`"
)
#: Largest track, bytes: more than a hundred thousand labels.
_LONGEST_TRACK = 1 << 24
#: Prefix of lines with the frequency range of the label on the line before.
_FREQUENCIES = "\\"


@dataclass(frozen=True, slots=True)
class Event:
    """Contact in a long file.

    ``row`` is the row of the table that states it, ``file`` the number of the file, and ``sample``
    the sample in the file, from 0. ``channel`` is the channel to use, None for all.
    """

    row: int
    file: int
    channel: int | None
    sample: int


def read_events(path: Path) -> Table:
    """Read a CSV table of contacts or an Audacity label track. Raise FileError if unusable."""
    table = (
        _read_track(path)
        if path.suffix.lower() == ".txt"
        else read_columns(path, SECONDS, SAMPLE, "onset")
    )
    for name in CONTACT_COLUMNS:
        if name in table and name != "first_finger":
            raise FileError(
                f"{path} has a column '{name}', which is relative to the start of a pinch: give "
                f"contacts from the start of the file, in a column '{SECONDS}' or '{SAMPLE}'"
            )
    onset_column(table)
    return table


def onset_column(table: Table) -> str:
    given = [name for name in (SECONDS, SAMPLE) if name in table]
    if len(given) != 1:
        raise FileError(
            f"{table.path} has {' and '.join(given) or f'neither {SECONDS} nor {SAMPLE}'}: give "
            f"each contact's time in a column '{SECONDS}', or its sample's number in a column "
            f"'{SAMPLE}'"
        )
    return given[0]


def find_events(
    table: Table,
    of_rows: Sequence[int | None],
    files: Sequence[Path],
    shapes: Sequence[tuple[int, ...]],
    rates: Sequence[float],
) -> list[Event]:
    """Return the contacts of a table, in the order of the rows.

    ``of_rows`` has the number of each row's file, None for rows to leave out. ``shapes`` (samples,
    channels) and ``rates``, Hz, are those of the ``files``. Raises FileError for a contact outside
    its file, and for one that occurs twice.
    """
    name = onset_column(table)
    used = {row: file for row, file in enumerate(of_rows) if file is not None}
    onsets = table.parsed(name, parse_number if name == SECONDS else parse_whole, used)
    channels: list[int | None] = [None] * len(used)
    if CHANNEL in table:
        channels = [*table.parsed(CHANNEL, parse_whole, used)]
    events = []
    for (row, file), onset, channel in zip(used.items(), onsets, channels, strict=True):
        (end, width), rate = shapes[file], rates[file]
        if channel is not None and not 0 <= channel < width:
            reason = f"but {files[file].name} has {width}"
            raise table.refusal(CHANNEL, row, reason, "give the channel's number, from 0")
        at = onset * rate if name == SECONDS else onset
        if not 0 <= at <= end - 1:
            last = f"{(end - 1) / rate:g} s" if name == SECONDS else end - 1
            raise table.refusal(name, row, f"outside {files[file].name} (0 to {last})")
        events.append(Event(row, file, channel, round(at)))
    for one, other in pairwise(sorted(events, key=_place)):
        if _place(one) == _place(other):
            raise FileError(
                f"{table.path}: {table.place(one.row)} and {table.place(other.row)} are the same "
                f"contact, at sample {one.sample} of {files[one.file].name}: remove one"
            )
    return events


def event_labels(
    table: Table, events: Sequence[Event], starts: Sequence[int]
) -> tuple[Table, list[str]]:
    """Return a table of labels with one row per contact, and notes for the user.

    ``starts`` has the first sample of the pinch around each contact. The table states the contact
    in samples from there.
    """
    labels = table.of_rows([event.row for event in events])
    labels["first_contact"] = [e.sample - start for e, start in zip(events, starts, strict=True)]
    return labels, note_unknown(table, set(table) - {SECONDS, SAMPLE, CHANNEL})


def spans(
    events: Sequence[Event], lengths: Sequence[int], rate: float
) -> tuple[list[int], list[int]]:
    """Return the first samples, and the ends, of the pinches to cut out around contacts.

    ``lengths`` are the numbers of samples of the files. Pinches of one file do not overlap.
    """
    lead, tail = round(BEFORE * rate), round(AFTER * rate)
    starts = [max(0, event.sample - lead) for event in events]
    stops = [min(lengths[event.file], event.sample + tail) for event in events]
    for i, j in pairwise(sorted(range(len(events)), key=lambda i: _place(events[i]))):
        one, other = events[i], events[j]
        if one.file == other.file:
            share = round((other.sample - one.sample) * AFTER / (BEFORE + AFTER))
            border = min(other.sample, one.sample + max(1, share))
            stops[i], starts[j] = min(stops[i], border), max(starts[j], border)
    return starts, stops


def _place(event: Event) -> tuple[int, int]:
    return event.file, event.sample


def _read_track(path: Path) -> Table:
    """Read an Audacity label track as a table of contacts. Raise FileError for an invalid line."""
    with library_errors(path, "an Audacity label track in UTF-8", "export it from Audacity again"):
        text = read_regular(path, _LONGEST_TRACK).decode("utf-8-sig")
    starts: list[float] = []
    texts: list[str] = []
    numbers: list[int] = []
    for number, line in enumerate(text.splitlines(), 1):
        if not line.strip() or line.startswith(_FREQUENCIES):
            continue
        fields = line.split("\t")
        try:
            # Some languages use a decimal comma.
            start, end = (parse_float(field.replace(",", ".")) for field in fields[:2])
        except ValueError:
            start, end = 1.0, 0.0
        if not start <= end:
            raise FileError(
                f"{path}: line {number} is {quote(line)}, which is no label: give start and end in "
                "seconds and a text, with tabs between"
            )
        numbers.append(number)
        starts.append(start)
        texts.append(" ".join(fields[2:]).strip())
    if not starts:
        raise FileError(f"{path} has no labels: give one line for each contact")
    return add_labels(Table(path, {SECONDS: starts}, numbers), texts)


def add_labels(table: Table, texts: Sequence[str]) -> Table:
    """Parse the ``texts`` of labels, one per row of the table, such as "eraser; shore_a=40".

    Return the table with a column for each label in them. Raises FileError for unknown labels.
    """
    rows: list[dict[str, str]] = []
    for number, text in enumerate(texts):
        row: dict[str, str] = {}
        for part in filter(None, map(str.strip, text.split(";"))):
            name, equals, value = (word.strip() for word in part.partition("="))
            name, value = (name, value) if equals else ("object", part)
            if name not in LABEL_COLUMNS or name in row:
                raise FileError(
                    f"{table.path}: {table.place(number)} has the unknown or repeated label "
                    f"{quote(part)}. Write the object's name, or name=value pairs separated by "
                    f"semicolons; names: {', '.join(LABEL_COLUMNS)}"
                )
            row[name] = value
        rows.append(row)
    names = [name for name in LABEL_COLUMNS if any(name in row for row in rows)]
    for name in names:
        lacking = next((i for i, row in enumerate(rows) if name not in row), None)
        if lacking is not None and name != "object":
            raise FileError(
                f"{table.path}: {table.place(lacking)} has no '{name}', but other lines have one: "
                "give it in all lines, or in none"
            )
    return table.with_columns({name: [row.get(name, "") for row in rows] for name in names})
