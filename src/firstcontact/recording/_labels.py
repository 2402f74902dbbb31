"""Conversion of table columns to labels and contacts, and of these and samples to pinches."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import (
    Block,
    ChannelKind,
    ClosingSpeed,
    Contact,
    Dataset,
    Finger,
    InputError,
    Label,
    Layout,
    Pinch,
    Role,
)
from firstcontact.recording import _cells as cells
from firstcontact.recording._cells import Columns, each, place
from firstcontact.recording._dataset import pause_between, shifted
from firstcontact.recording._quoting import quote

#: Columns that describe the object and how the hand closed on it.
LABEL_COLUMNS = (
    "object",
    "material",
    "shore_a",
    "hardness_rank",
    "hardness_class",
    "specimen",
    "session",
    "role",
    "closing_speed",
    "closing_speed_error",
)
#: Columns with the contacts and the start of the motor.
CONTACT_COLUMNS = (
    "first_contact",
    "pre_trigger_samples",
    "second_contact",
    "first_finger",
    "motor_start",
)
#: Largest voltage of a vibration sensor without a warning, V.
MOST_VOLTS = 10.0
#: Session of all pinches of a file without sessions.
ASSUMED_SESSION = "1"
#: Time after a contact in which the fingers are compared if the labels name none, s.
_LISTEN = 0.005


def labelled(
    origin: str,
    cuts: Sequence[NDArray[Any]],
    layout: Layout,
    columns: Columns,
    source: str,
    notes: Sequence[str],
    *,
    starts: Sequence[int] | None = None,
    groups: Sequence[Mapping[str, Block]] | None = None,
    exported: bool = False,
) -> Dataset:
    """Build pinches from the data of an importer."""
    labels, assumed = make_labels(origin, columns, len(cuts))
    contacts, guessed = make_contacts(origin, columns, cuts, layout, exported)
    motors = make_motor_starts(origin, columns, [len(c) for c in cuts], contacts)
    speeds = make_closing_speeds(origin, columns, len(cuts))
    pinches = [
        Pinch(cut, layout, label, 0, truth, motor, closing_speed=speed)
        for cut, label, truth, motor, speed in zip(
            cuts, labels, contacts, motors, speeds, strict=True
        )
    ]
    pieces = layout.columns(ChannelKind.VIBRATION)
    peak = max((float(np.abs(layout.physical(c, pieces)).max(initial=0)) for c in cuts), default=0)
    units = {c.unit for c in layout.channels if c.kind is ChannelKind.VIBRATION}
    if units == {"V"} and peak > MOST_VOLTS and not exported:
        notes = [
            *notes,
            f"warning: {origin} reaches {peak:.3g} V, and piezos rarely exceed {MOST_VOLTS:g} V: "
            "if the numbers are mV, divide them by 1000 and import again",
        ]
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
        source,
        (*assumed, *guessed, *notes),
        sessions_assumed="session" not in columns,
    )


def make_labels(origin: str, columns: Columns, pinches: int) -> tuple[list[Label], list[str]]:
    """Return the label of each pinch, and notes on assumptions."""
    for one, other in (("object", "material"), ("hardness_rank", "hardness_class")):
        if one in columns and other in columns:
            raise InputError(f"{origin} has both '{one}' and '{other}': keep one of them")
    notes = []
    objects = (
        each(origin, columns, "object", cells.words)
        or each(origin, columns, "material", cells.words)
        or [""] * pinches
    )
    shore = each(origin, columns, "shore_a", cells.shore)
    rank = each(origin, columns, "hardness_rank", cells.ranked) or each(
        origin, columns, "hardness_class", cells.rank
    )
    specimens = each(origin, columns, "specimen", cells.name)
    if specimens is None:
        unit, values = _assumed_specimens(objects, shore, rank)
        specimens = [str(v) for v in values or ["unknown"] * pinches]
        notes.append(
            f"no specimen column: {f'one specimen for each {unit}' if unit else 'one specimen'} "
            "was assumed"
        )
    sessions = each(origin, columns, "session", cells.name)
    if sessions is None:
        sessions = [ASSUMED_SESSION] * pinches
        notes.append("no session column: all pinches were taken as one session")
    if shore is None and rank is None:
        notes.append("no shore_a, hardness_rank or hardness_class column: stiffness is not known")
    roles = each(origin, columns, "role", cells.role) or [Role.TRAIN] * pinches
    labels = [
        Label(
            objects[i],
            None if shore is None else shore[i],
            None if rank is None else rank[i],
            specimens[i],
            sessions[i],
            roles[i],
        )
        for i in range(pinches)
    ]
    return labels, notes


def make_contacts(
    origin: str,
    columns: Columns,
    samples: Sequence[NDArray[Any]],
    layout: Layout,
    exported: bool = False,
) -> tuple[list[tuple[Contact, ...]], list[str]]:
    """Return the known contacts of each pinch, counted from its first sample."""
    if "first_contact" in columns and "pre_trigger_samples" in columns:
        raise InputError(
            f"{origin} has both 'first_contact' and 'pre_trigger_samples': keep one of them"
        )
    name = "pre_trigger_samples" if "pre_trigger_samples" in columns else "first_contact"
    unknown = [-1] * len(samples)
    firsts = each(origin, columns, name, cells.integer) or unknown
    seconds = each(origin, columns, "second_contact", cells.integer) or unknown
    fingers = each(origin, columns, "first_finger", cells.finger) or [None] * len(samples)
    vibration, owners = list(layout.columns(ChannelKind.VIBRATION)), layout.vibration_fingers
    is_exact = exported and "first_finger" in columns
    contacts = []
    guessed = moved = 0
    for i, (first, second, finger, data) in enumerate(
        zip(firsts, seconds, fingers, samples, strict=True)
    ):
        for field, sample in ((name, first), ("second_contact", second)):
            if not -1 <= sample < len(data):
                raise InputError(
                    f"{origin}: '{field}' of {place(columns, i)} is {quote(sample)}, outside the "
                    f"pinch's {len(data)} samples: count from 0 within it, or give -1 if unknown"
                )
        if second >= 0 > first:
            raise InputError(
                f"{origin}: {place(columns, i)} has a 'second_contact' ({second}) but no "
                f"'{name}': give '{name}', or -1 as 'second_contact'"
            )
        if 0 <= second < first:
            raise InputError(
                f"{origin}: 'second_contact' of {place(columns, i)} ({second}) is before its "
                f"'{name}' ({first}): correct one of them"
            )
        touched = finger
        if len(owners) == 1 and not is_exact:
            touched = owners[0]
            moved += touched is Finger.INDEX and finger is Finger.THUMB and first >= 0
        elif touched is None and first >= 0 and not is_exact:
            touched = _louder_finger(data[:, vibration], first, second, layout.rate)
            guessed += 1
        marks = [(touched, first), (None if touched is None else touched.other, second)]
        contacts.append(tuple(Contact(f, s, s) for f, s in marks if s >= 0))
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


def make_motor_starts(
    origin: str, columns: Columns, lengths: Sequence[int], contacts: Sequence[tuple[Contact, ...]]
) -> list[int | None]:
    """Return the start of the motor in each pinch, counted from its first sample."""
    starts = each(origin, columns, "motor_start", cells.integer) or [-1] * len(lengths)
    for i, (start, length, pinch_contacts) in enumerate(
        zip(starts, lengths, contacts, strict=True)
    ):
        end = pinch_contacts[0].sample if pinch_contacts else length
        if not -1 <= start < max(end, 0):
            raise InputError(
                f"{origin}: 'motor_start' of {place(columns, i)} is {quote(start)}, outside the "
                f"{end} samples before its {('first contact' if pinch_contacts else 'end')}: "
                "count from 0 within the pinch, or give -1 if unknown"
            )
    return [None if start < 0 else start for start in starts]


def make_closing_speeds(origin: str, columns: Columns, pinches: int) -> list[ClosingSpeed | None]:
    """Return the measured closing speed of each pinch."""
    speeds = each(origin, columns, "closing_speed", cells.speed)
    errors = each(origin, columns, "closing_speed_error", cells.speed_error)
    if speeds is None:
        return [None] * pinches
    if errors is None:
        raise InputError(
            f"{origin}: there is 'closing_speed' but no 'closing_speed_error': give the standard "
            "error in m/s, 0 if the speed is exact"
        )
    for i, (speed, error) in enumerate(zip(speeds, errors, strict=True)):
        if speed >= 0 > error:
            raise InputError(
                f"{origin}: 'closing_speed_error' of {place(columns, i)} is {quote(error)}, but "
                "the speed is known: give the standard error in m/s, 0 if the speed is exact"
            )
    return [
        None if speed < 0 else ClosingSpeed(speed, error)
        for speed, error in zip(speeds, errors, strict=True)
    ]


def _louder_finger(signals: NDArray[Any], first: int, second: int, rate: float) -> Finger:
    """Return the finger whose vibration rose more above its noise after the first contact."""
    volts = signals.astype(np.float64)
    quiet = volts[: max(first, 1)]
    end = max(first + round(_LISTEN * rate), first + 2)
    if second > first + 1:
        end = min(end, second)
    moved = np.abs(volts[first:end] - quiet.mean(axis=0)).max(axis=0)
    scale = np.maximum(quiet.std(axis=0), 1e-9 * max(float(moved.max()), 1e-30))
    return Finger(int(np.argmax(moved / scale)))


def _assumed_specimens(
    objects: list[str], shore: list[float] | None, rank: list[int] | None
) -> tuple[str, list[Any] | None]:
    """Return the name and the values of the label that stands in for the specimen, if any."""
    if any(objects):
        return "object", objects
    if shore is not None:
        return "shore_a", [f"{s:g}" for s in shore]
    if rank is not None:
        return "hardness rank", rank
    return "", None
