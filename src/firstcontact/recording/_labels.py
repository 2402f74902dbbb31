"""Conversion of imported labels, contacts and samples to a dataset of pinches.

The parsers of cells raise ValueError with words that continue a sentence: "which is too long".
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from difflib import get_close_matches
from enum import StrEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import (
    Block,
    ChannelKind,
    ClosingSpeed,
    Contact,
    Dataset,
    FileError,
    Finger,
    InputError,
    Label,
    Layout,
    Pinch,
    Role,
)
from firstcontact.core.given import plain_name
from firstcontact.core.physics import LEAST, MOST, parse_radius, radius_text
from firstcontact.core.pinch import FASTEST, SLOWEST
from firstcontact.core.quantity import MODULUS, PHYSICAL, QUANTITIES, RANK, SHORE_A, STIFFNESS
from firstcontact.core.records import LONGEST_NAME
from firstcontact.core.text import parse_float
from firstcontact.core.units import plain_unit
from firstcontact.recording.dataset import pause_between, shifted
from firstcontact.recording.messages import SOURCES
from firstcontact.recording.table import Table
from firstcontact.recording.untrusted import as_text, listed, one_of, quote

#: Names of hardness classes, from soft to hard.
CLASSES = ("soft", "medium", "hard")
#: Largest voltage of a vibration sensor without a warning, V.
MOST_VOLTS = 10.0
#: Session of all pinches of a file without sessions.
ASSUMED_SESSION = "1"
#: Time after a contact in which the fingers are compared if the labels name none, s.
_LISTEN = 0.005
#: Smallest similarity, from 0 to 1, of two names of which one is taken for a misspelling.
_ALIKE = 0.75


def parse_text(value: Any) -> str:
    """Return a cell as text in one spelling. Raise ValueError if the text is too long."""
    if isinstance(value, np.void | np.ndarray):  # a NumPy record, or untyped bytes
        raise ValueError("which must be a text or a number")
    text = plain_name(as_text(value))
    if len(text) > LONGEST_NAME:
        raise ValueError(f"which is longer than {LONGEST_NAME} characters")
    return text


def parse_number(value: Any) -> float:
    return parse_float(as_text(value))


def parse_whole(value: Any) -> int:
    number = parse_number(value)
    if number != int(number):
        raise ValueError("which is not a whole number")
    return int(number)


def parse_finger(value: Any) -> Finger | None:
    """Parse a cell with a finger: "index" or 0, "thumb" or 1. Return None for "" and -1."""
    text = as_text(value).strip().lower()
    with suppress(ValueError):
        text = str(parse_whole(text))
    for finger in Finger:
        if text in (str(int(finger)), finger.name.lower()):
            return finger
    if text in ("", "-1"):
        return None
    raise ValueError("which must be index (0) or thumb (1)")


def parse_name(value: Any) -> str:
    text = parse_text(value)
    if not text:
        raise ValueError("which must not be empty")
    return text


def _parse_class(value: Any) -> int:
    text = as_text(value).strip().lower()
    return CLASSES.index(text) if text in CLASSES else _parse_rank(text)


def choice(kind: type[StrEnum]) -> Callable[[Any], Any]:
    """Return a parser of cells that name a member of the enumeration ``kind``."""

    def parse_choice(value: Any) -> StrEnum:
        try:
            return kind(as_text(value).strip().lower())
        except ValueError:
            raise ValueError(f"which must be one of {', '.join(kind)}") from None

    return parse_choice


def _parse_shape(value: Any) -> str:
    text = parse_text(value)
    try:
        radius = parse_radius("" if text == "-1" else text)
    except InputError:
        raise ValueError(f"which must be flat, or a radius from {LEAST:g} to {MOST:g} mm") from None
    return radius_text(radius).removeprefix("radius ")


def bounded(
    parse: Callable[[Any], Any], low: float, high: float, *, or_unknown: bool = False
) -> Callable[[Any], Any]:
    """Return a parser that calls ``parse`` and checks that the number is from ``low`` to ``high``.

    With ``or_unknown``, the number -1 (unknown) is also allowed.
    """

    def parse_bounded(value: Any) -> Any:
        number = parse(value)
        if not low <= number <= high and not (or_unknown and number == -1):
            unknown = ", or -1 if unknown" if or_unknown else ""
            raise ValueError(f"which must be from {low:g} to {high:g}{unknown}")
        return number

    return parse_bounded


_parse_rank = bounded(parse_whole, RANK.least, RANK.most)
#: Columns that describe the object and how the hand closed on it, with their parsers.
LABEL_COLUMNS: Mapping[str, Callable[[Any], Any]] = {
    "object": parse_text,
    "material": parse_text,
    **{q.name: bounded(parse_number, q.least, q.most) for q in PHYSICAL},
    "hardness_rank": _parse_rank,
    "hardness_class": _parse_class,
    "specimen": parse_name,
    "session": parse_name,
    "role": choice(Role),
    "shape": _parse_shape,
    "closing_speed": bounded(parse_number, SLOWEST, FASTEST, or_unknown=True),
    "closing_speed_error": bounded(parse_number, 0.0, FASTEST, or_unknown=True),
}
#: Columns with the contacts and the start of the motor, with their parsers.
CONTACT_COLUMNS: Mapping[str, Callable[[Any], Any]] = {
    "first_contact": parse_whole,
    "pre_trigger_samples": parse_whole,
    "second_contact": parse_whole,
    "first_finger": parse_finger,
    "motor_start": parse_whole,
}
_SPEEDS = {"m/s": 1.0, "mm/s": 1e-3, "cm/s": 1e-2}
#: Units that the name of a column may have, in lower case, with the factors that convert them.
_UNITS = {
    **{q.name: q.units for q in PHYSICAL},
    "closing_speed": _SPEEDS,
    "closing_speed_error": _SPEEDS,
}
PINCH_COLUMNS = {**LABEL_COLUMNS, **CONTACT_COLUMNS}


def make_dataset(
    table: Table,
    cuts: Sequence[NDArray[Any]],
    layout: Layout,
    *,
    source: str | None = None,
    notes: Sequence[str] = (),
    starts: Sequence[int] | None = None,
    groups: Sequence[Mapping[str, Block]] | None = None,
    exported: bool = False,
) -> Dataset:
    """Make a dataset from a table of labels, one row per pinch, and the samples of each pinch.

    ``cuts`` are the raw samples, shape (samples, width of ``layout``). ``starts`` are the numbers
    of their first samples; by default the pinches are numbered one after the other. ``groups`` are
    each pinch's samples of slower channels, by name. ``exported`` is True for files that this
    package exported. Raises FileError, which names the cell, for an unusable label.
    """
    labels, assumed = _labels(table, len(cuts))
    contacts, guessed = _parse_contacts(table, cuts, layout, exported)
    motors = _motor_starts(table, [len(cut) for cut in cuts], contacts)
    speeds = _closing_speeds(table, len(cuts))
    pinches = [
        Pinch(cut, layout, label, 0, truth, motor, closing_speed=speed)
        for cut, label, truth, motor, speed in zip(
            cuts, labels, contacts, motors, speeds, strict=True
        )
    ]
    columns = layout.columns(ChannelKind.VIBRATION)
    peak = max((float(np.abs(layout.physical(c, columns)).max(initial=0)) for c in cuts), default=0)
    warnings = []
    if {c.unit for c in layout.vibration} == {"V"} and peak > MOST_VOLTS and not exported:
        warnings.append(
            f"warning: {table.path} reaches {peak:.3g} V, and piezos rarely exceed "
            f"{MOST_VOLTS:g} V: if the numbers are mV, divide them by 1000 and import again"
        )
    if starts is None:
        numbered = pause_between(pinches)
    else:
        beside = groups or [{} for _ in pinches]
        numbered = tuple(
            replace(shifted(pinch, start), groups=pinch_groups)
            for pinch, start, pinch_groups in zip(pinches, starts, beside, strict=True)
        )
    return Dataset(
        numbered,
        _stated_source(table) if source is None else source,
        (*assumed, *guessed, *notes, *warnings),
        sessions_assumed="session" not in table,
    )


def note_unknown(table: Table, names: Iterable[str], noun: str = "columns") -> list[str]:
    """Return a list with a note about the ``names`` that are not names of labels; [] if all are.

    The note asks about names that look like a misspelt label. ``noun`` is the word for what has
    these names in the file, such as "columns".
    """
    unknown = sorted(set(names) - {*PINCH_COLUMNS, "file", "source", "comment"})
    questions = [
        f"did you mean {match} where it says {quote(name)}?"
        for name in unknown
        for match in get_close_matches(name.lower(), PINCH_COLUMNS, 1, _ALIKE)
        if match not in table
    ]
    sentence = f"{table.path.name}: unknown {noun} were left out: {listed(unknown)}"
    return ["; ".join([sentence, *questions])] if unknown else []


def _stated_source(table: Table) -> str:
    sources = sorted(set(table.get("source", ["unknown"])))
    if len(sources) > 1:
        raise FileError(
            f"{table.path}: the column 'source' must be the same in all rows: import each source "
            "separately"
        )
    return one_of(table.path, "source", sources[0], SOURCES)


def _parse_column(table: Table, name: str) -> list[Any] | None:
    """Parse a column of labels. Return its values; None if the table lacks the column.

    Numbers in the unit of the column's header are converted to the unit of the label.
    """
    unit, factors = table.units.get(name), _UNITS.get(name, {})
    spelling = plain_unit(unit or "")
    factor = 1.0 if unit is None else factors.get(spelling, factors.get(spelling.lower()))
    if not factor:
        usual = QUANTITIES[name].unit if name in QUANTITIES else next(iter(factors), "")
        known = f"the unit {usual}" if usual else "numbers without a unit"
        raise FileError(
            f"{table.path}: '{name}' has the unit {quote(unit)}: give {known}, and correct the "
            "name of the column"
        )
    if name not in table:
        return None
    if factor != 1.0:
        numbers = table.parsed(name, parse_number)
        converted = [repr(n if n == -1 else n * factor) for n in numbers]
        table = table.with_columns({name: converted})
    return table.parsed(name, PINCH_COLUMNS[name])


def _parse_either(table: Table, name: str, other: str) -> list[Any] | None:
    """Parse the column ``name`` or ``other``. Return its values; None if both are missing.

    Raises FileError if both columns exist.
    """
    if name in table and other in table:
        raise FileError(
            f"{table.path} has both the columns '{name}' and '{other}': keep one of them"
        )
    return _parse_column(table, other if other in table else name)


def _labels(table: Table, pinches: int) -> tuple[list[Label], list[str]]:
    notes = []
    objects = _parse_either(table, "object", "material") or [""] * pinches
    rank = _parse_either(table, "hardness_rank", "hardness_class")
    physical = {
        q.name: values for q in PHYSICAL if (values := _parse_column(table, q.name)) is not None
    }
    if len(physical) > 1:
        raise FileError(
            f"{table.path} has the columns {' and '.join(physical)}: keep one of them, because a "
            "dataset has one quantity"
        )
    specimens = _parse_column(table, "specimen")
    if specimens is None:
        unit, specimens = "", ["unknown"] * pinches
        if any(objects):
            unit, specimens = "object", objects
        elif physical:
            [(unit, levels)] = physical.items()
            specimens = [f"{level:g}" for level in levels]
        elif rank is not None:
            unit, specimens = "hardness rank", [str(r) for r in rank]
        each = f"one specimen for each {unit}" if unit else "one specimen"
        notes.append(f"no specimen column: {each} was assumed")
    sessions = _parse_column(table, "session")
    if sessions is None:
        sessions = [ASSUMED_SESSION] * pinches
        notes.append("no session column: all pinches were taken as one session")
    if not physical and rank is None:
        notes.append(f"no {', '.join(QUANTITIES)} or hardness_class column: stiffness is not known")
    roles = _parse_column(table, "role") or [Role.TRAIN] * pinches
    shapes = _parse_column(table, "shape") or [""] * pinches
    unknown = [None] * pinches
    shore, modulus, stiffness = (
        physical.get(q.name) or unknown for q in (SHORE_A, MODULUS, STIFFNESS)
    )
    columns = objects, shore, rank or unknown, specimens, sessions, roles, shapes
    rows = zip(*columns, modulus, stiffness, strict=True)
    return [Label(*row) for row in rows], notes


def _parse_contacts(
    table: Table, cuts: Sequence[NDArray[Any]], layout: Layout, exported: bool
) -> tuple[list[tuple[Contact, ...]], list[str]]:
    """Return the contacts of each pinch, as a table states them, and notes for the user.

    Their samples are counted from the first sample of the pinch. If the table does not name the
    first finger, it is the one whose vibration rises more. ``exported`` is True for files that this
    package exported.
    """
    unknown = [-1] * len(cuts)
    firsts = _parse_either(table, "first_contact", "pre_trigger_samples") or unknown
    name = "pre_trigger_samples" if "pre_trigger_samples" in table else "first_contact"
    seconds = _parse_column(table, "second_contact") or unknown
    fingers = _parse_column(table, "first_finger") or [None] * len(cuts)
    owners, vibration = layout.vibration_fingers, list(layout.columns(ChannelKind.VIBRATION))
    is_exact = exported and "first_finger" in table
    contacts = []
    guessed = moved = 0
    for row, (first, second, finger, cut) in enumerate(
        zip(firsts, seconds, fingers, cuts, strict=True)
    ):
        for field, sample in ((name, first), ("second_contact", second)):
            if not -1 <= sample < len(cut):
                reason = f"outside the pinch's {len(cut)} samples"
                raise table.refusal(field, row, reason, "count from 0, or give -1 if unknown")
        if second >= 0 and not 0 <= first <= second:
            reason = f"before '{name}' ({first})"
            raise table.refusal("second_contact", row, reason, "correct one, or give -1")
        if len(owners) == 1 and not is_exact:
            moved += finger is Finger.THUMB and owners[0] is Finger.INDEX and first >= 0
            finger = owners[0]
        elif finger is None and first >= 0 and not is_exact:
            finger = _louder_finger(cut[:, vibration], first, second, layout.rate)
            guessed += 1
        marks = [(finger, first), (None if finger is None else finger.other, second)]
        contacts.append(tuple(Contact(f, sample, sample) for f, sample in marks if sample >= 0))
    notes = []
    if guessed:
        notes.append(
            f"first_finger of {guessed} pinches is not known: taken as the finger whose sensor "
            "moved more in the 5 ms after the first contact"
        )
    if moved:
        notes.append(
            f"first_finger of {moved} pinches is the thumb, but there is only one channel: the "
            "channel was taken as that of the finger that touched first"
        )
    return contacts, notes


def _motor_starts(
    table: Table, lengths: Sequence[int], contacts: Sequence[tuple[Contact, ...]]
) -> list[int | None]:
    """Return the sample at which the motor starts, for each pinch; None if unknown.

    It is counted from the first sample of the pinch. ``lengths`` are the numbers of samples.
    """
    starts = _parse_column(table, "motor_start") or [-1] * len(lengths)
    for row, (start, length, truth) in enumerate(zip(starts, lengths, contacts, strict=True)):
        end = truth[0].sample if truth else length
        if not -1 <= start < max(end, 0):
            reason = f"outside the {end} samples before its {'first contact' if truth else 'end'}"
            raise table.refusal("motor_start", row, reason, "count from 0, or give -1 if unknown")
    return [None if start < 0 else start for start in starts]


def _closing_speeds(table: Table, pinches: int) -> list[ClosingSpeed | None]:
    speeds = _parse_column(table, "closing_speed")
    errors = _parse_column(table, "closing_speed_error")
    if speeds is None:
        return [None] * pinches
    for row, (speed, error) in enumerate(zip(speeds, errors or [-1] * pinches, strict=True)):
        if speed >= 0 > error:
            reason = "but 'closing_speed_error' is missing"
            raise table.refusal("closing_speed", row, reason, "give the standard error in m/s")
    return [
        None if speed < 0 else ClosingSpeed(speed, error)
        for speed, error in zip(speeds, errors or speeds, strict=True)
    ]


def _louder_finger(signals: NDArray[Any], first: int, second: int, rate: float) -> Finger:
    """Return the finger whose vibration rises more above its noise after the first contact.

    ``signals`` has the shape (samples, fingers). The contacts are at the samples ``first`` and
    ``second``, which is -1 if unknown.
    """
    volts = signals.astype(np.float64)
    quiet = volts[: max(first, 1)]
    end = max(first + round(_LISTEN * rate), first + 2)
    if second > first + 1:
        end = min(end, second)
    moved = np.abs(volts[first:end] - quiet.mean(axis=0)).max(axis=0)
    scale = np.maximum(quiet.std(axis=0), 1e-9 * max(float(moved.max()), 1e-30))
    return Finger(int(np.argmax(moved / scale)))
