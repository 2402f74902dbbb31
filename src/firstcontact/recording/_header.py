"""What a recording says about itself, and the marks made in it."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field, replace
from typing import Annotated, Any

from msgspec import Meta

from firstcontact.core import (
    Calibration,
    Contact,
    Count,
    Finger,
    InputError,
    Label,
    Layout,
    Name,
    Notes,
    read_record,
)

#: Name and version of the format; a reader refuses any other.
FORMAT = "firstcontact.recording"
VERSION = 2
#: Those that a reader knows: 1 says of vibration channels that they are piezos.
_VERSIONS = (1, VERSION)
#: Where samples can come from.
SOURCES = ("twin", "real", "synthetic", "unknown")
#: Sample types a recording can hold, little-endian.
DTYPES = {"int16": "<i2", "int32": "<i4", "float32": "<f4"}
#: Sample numbers end here: further than any device counts, and exact in floats and JSON.
LAST_SAMPLE = 1 << 53
#: Most characters of a marker's text.
LONGEST_TEXT = 20_000
#: Most bytes of a mark or marker.
LONGEST_MARK = 1 << 17

#: What importers wrote into the notes before ``session_assumed`` was there.
_OLD_ASSUMPTION = "no session column: all pinches were taken as one session"

Sample = Annotated[int, Meta(ge=0, le=LAST_SAMPLE)]
Epoch = Annotated[int, Meta(ge=0, lt=1 << 32)]


@dataclass(frozen=True, slots=True)
class Header:
    """What a recording says about itself. "" means not known.

    Parameters
    ----------
    layout
        The columns, their rate and units.
    source
        "twin", "real", "synthetic" or "unknown".
    dtype
        Type of the samples: "int16", "int32" or "float32".
    sensor, hand, firmware
        What was recorded with.
    session
        The stretch of collecting data that the recording belongs to.
    notes
        The operator's words.
    created
        ISO 8601 time. A simulated recording leaves it empty, since the same
        seed must give the same bytes.
    calibration
        What was measured of the fingertips, where that was done.
    session_assumed
        Whether nobody named a session, so that an importer took all pinches as one.
    """

    layout: Layout
    source: str = "unknown"
    dtype: str = "int16"
    sensor: Name = ""
    hand: Name = ""
    firmware: Name = ""
    session: Name = ""
    notes: Notes = ""
    created: Name = ""
    calibration: Calibration | None = None
    session_assumed: bool = False

    def __post_init__(self) -> None:
        if fault := self.layout.fault:
            raise ValueError(f"layout has {fault}")
        if self.source not in SOURCES:
            raise ValueError(f"source is {self.source!r}, not one of {', '.join(SOURCES)}")
        if self.dtype not in DTYPES:
            raise ValueError(f"dtype is {self.dtype!r}, not one of {', '.join(DTYPES)}")

    def to_json(self) -> dict[str, Any]:
        """A JSON-ready form, with the name and version of the format."""
        tree = {"format": FORMAT, "version": VERSION, **asdict(self)}
        if self.calibration is None:
            del tree["calibration"]
        if not self.session_assumed:
            del tree["session_assumed"]
        return {**tree, "layout": self.layout.to_json()}


@dataclass(frozen=True, slots=True)
class _Head:
    """What tells our headers from others, and one version from another."""

    format: str = ""
    version: int | None = None


def read_header(data: bytes, where: str) -> Header:
    """What ``/header`` holds.

    Raises
    ------
    InputError
        It is not ours, of another version, or a field is missing or out of bounds.
    """
    remedy = "write the file again from its source"
    data = data.rstrip(b" ")
    head = read_record(data, _Head, where, remedy)
    if head.format != FORMAT:
        raise InputError(
            f"{where} is not that of a firstcontact recording: bring other data in with "
            "`firstcontact import`"
        )
    if head.version not in _VERSIONS:
        raise InputError(
            f"{where} says format version {head.version!r} and this reader knows {VERSION}: "
            "install the firstcontact that wrote it"
        )
    header = read_record(data, Header, where, remedy)
    if _OLD_ASSUMPTION in header.notes.splitlines():
        return replace(header, session_assumed=True)
    return header


@dataclass(frozen=True, slots=True)
class _Touch:
    """A contact as a mark holds it."""

    finger: Finger | None
    sample: Sample


@dataclass(frozen=True, slots=True)
class _Mark:
    """A mark as a recording holds it; other fields than those of :class:`PinchMark`."""

    number: Count
    first_sample: Sample
    end: Sample
    epoch: Epoch
    label: Label
    truth: Annotated[tuple[_Touch, ...], Meta(max_length=len(Finger))]
    motor_start: Sample | None = None
    found: Annotated[tuple[_Touch, ...], Meta(max_length=len(Finger))] = ()
    found_by: Name = ""

    def __post_init__(self) -> None:
        if self.end <= self.first_sample:
            raise ValueError(f"it ends at {self.end} and begins at {self.first_sample}")
        samples = [c.sample for c in self.truth]
        fingers = [c.finger for c in self.truth if c.finger is not None]
        if samples != sorted(samples) or len(set(fingers)) < len(fingers):
            raise ValueError("its contacts are not those of two fingers, one after the other")
        inside = [
            *samples,
            *(c.sample for c in self.found),
            *([] if self.motor_start is None else [self.motor_start]),
        ]
        if not all(self.first_sample <= sample < self.end for sample in inside):
            raise ValueError("a contact or the motor's start is outside of its samples")


@dataclass(frozen=True, slots=True)
class PinchMark:
    """Where a pinch lies in a recording, and what is known about it.

    Parameters
    ----------
    number
        Counts the pinches of a recording from 0, so that a lost mark shows.
    first_sample, end
        Device sample numbers: the first, and one past the last.
    epoch
        The epoch that both belong to.
    label
        What was pinched.
    truth
        Known contacts, in the order of time.
    motor_start
        Device sample number from which the motor closes the hand, None where not known.
    found
        Contacts that a detector marked while it was recorded: not the truth, but where to look
        for it.
    found_by
        Name of that detector.
    """

    number: int
    first_sample: int
    end: int
    epoch: int = 0
    label: Label = field(default_factory=Label)
    truth: tuple[Contact, ...] = ()
    motor_start: int | None = None
    found: tuple[Contact, ...] = ()
    found_by: str = ""

    def to_json(self) -> dict[str, Any]:
        """A JSON-ready form."""
        tree = {
            "number": self.number,
            "first_sample": self.first_sample,
            "end": self.end,
            "epoch": self.epoch,
            "label": self.label.to_json(),
            "truth": [{"finger": c.finger, "sample": c.sample} for c in self.truth],
        }
        if self.motor_start is not None:
            tree["motor_start"] = self.motor_start
        if self.found:
            tree["found"] = [{"finger": c.finger, "sample": c.sample} for c in self.found]
            tree["found_by"] = self.found_by
        return tree


def read_mark(data: bytes, where: str) -> PinchMark:
    """What ``/pinch`` holds.

    Raises
    ------
    InputError
        A field is missing or out of bounds, or its samples contradict each other.
    """
    m = read_record(data, _Mark, where, "mark the pinch again", LONGEST_MARK)
    truth = tuple(Contact(c.finger, c.sample, c.sample) for c in m.truth)
    found = tuple(Contact(c.finger, c.sample, c.sample) for c in m.found)
    return PinchMark(
        m.number, m.first_sample, m.end, m.epoch, m.label, truth, m.motor_start, found, m.found_by
    )


@dataclass(frozen=True, slots=True)
class Marker:
    """A word of the operator or of a device, pinned to a sample."""

    sample: Sample
    text: Annotated[str, Meta(max_length=LONGEST_TEXT)]
    epoch: Epoch = 0


def read_marker(data: bytes, where: str) -> Marker:
    """What ``/marker`` holds.

    Raises
    ------
    InputError
        A field is missing or out of bounds.
    """
    return read_record(data, Marker, where, "mark the sample again", LONGEST_MARK)
