"""Messages of a recording: header, samples, marks of pinches, and markers (texts).

A message with samples is encoded as ROS 2 CDR, so that viewers can plot it. The page
docs/reference/recording-format.md describes its bytes and the fields of the others.
"""

from __future__ import annotations

import struct
from dataclasses import asdict, dataclass, field
from typing import Annotated, Any

import numpy as np
from msgspec import Meta
from numpy.typing import NDArray

from firstcontact.core import (
    ArgumentError,
    Block,
    Calibration,
    Channel,
    ChannelKind,
    ClosingSpeed,
    Contact,
    FileError,
    Finger,
    Group,
    Label,
    Layout,
)
from firstcontact.core.given import given_name
from firstcontact.core.pinch import check_contacts
from firstcontact.core.records import Count, Name, Notes, read_record

#: Name and version of the format. Readers refuse others.
FORMAT = "firstcontact.recording"
VERSION = 2
#: Versions that readers accept. In version 1 all vibration channels are piezos.
_VERSIONS = (1, VERSION)
#: Sources of samples.
SOURCES = ("twin", "real", "synthetic", "unknown")
#: Sample types of recordings, little-endian.
DTYPES = {"int16": "<i2", "int32": "<i4", "float32": "<f4"}
#: Largest sample number: beyond any device, and exact in floats and JSON.
LAST_SAMPLE = 1 << 53
#: Longest text of a marker, characters.
LONGEST_TEXT = 20_000
#: Longest mark or marker, bytes.
LONGEST_MARK = 1 << 17
#: Largest float sample: its squares and sums stay finite in 32 bits.
LARGEST = 1e12
_CDR_LITTLE_ENDIAN = b"\x00\x01\x00\x00"
#: Encoding, first sample, epoch, channels, number of values.
_PREFIX = struct.Struct("<4sQIHxxI")

#: Name of the group with the positions of the hand.
HAND = "hand"

Sample = Annotated[int, Meta(ge=0, le=LAST_SAMPLE)]
Epoch = Annotated[int, Meta(ge=0, lt=1 << 32)]


@dataclass(frozen=True, slots=True)
class Header:
    """Description of a recording, stored at its start. In a text field, "" means unknown.

    Parameters
    ----------
    layout, calibration
        Columns of the samples with units and rate, and calibration of the fingertips, None if they
        were not calibrated.
    source
        Origin of the samples: "twin" (simulated hand), "real", "synthetic" or "unknown".
    dtype
        NumPy type of the samples: "int16", "int32" or "float32".
    sensor, hand, firmware, session, notes
        Names of the sensor, hand, firmware version and session, and free text of the operator.
    created
        Time of the recording, ISO 8601; "" in simulations, so that a seed gives the same bytes.
    session_assumed
        True if imported files named no session, so that all pinches were treated as one session.
    """

    layout: Layout
    source: Annotated[str, Meta(pattern=f"^({'|'.join(SOURCES)})$")] = "unknown"
    dtype: Annotated[str, Meta(pattern=f"^({'|'.join(DTYPES)})$")] = "int16"
    sensor: Name = ""
    hand: Name = ""
    firmware: Name = ""
    session: Name = ""
    notes: Notes = ""
    created: Name = ""
    calibration: Calibration | None = None
    session_assumed: bool = False

    def __post_init__(self) -> None:
        if fault := self.layout.why_unusable:
            raise ValueError(f"the field 'layout' has {fault}")
        object.__setattr__(self, "session", given_name(self.session, "session"))

    def to_json(self) -> dict[str, Any]:
        """Return the header as a dict for JSON, with the name and version of the format."""
        tree = {"format": FORMAT, "version": VERSION, **asdict(self)}
        if self.calibration is None:
            del tree["calibration"]
        if not self.session_assumed:
            del tree["session_assumed"]
        return {**tree, "layout": self.layout.to_json()}


def hand_group(rate: float, resolution: float) -> Group:
    """Return the group of channels that stores the positions of a hand.

    ``rate`` is the rate of the positions, Hz, and ``resolution`` the step that is stored, m.
    """
    travel = Channel("hand_travel", ChannelKind.POSITION, None, "m", resolution)
    return Group(HAND, Layout((travel,), rate))


@dataclass(frozen=True, slots=True)
class _Head:
    """Name and version of the format, as they stand in the header of a recording."""

    format: str = ""
    version: int | None = None


def read_header(data: bytes, origin: str) -> Header:
    """Parse the header of a recording from its message.

    Raises FileError, with the name ``origin``, for another format or version.
    """
    remedy = "write the file again from its source"
    data = data.rstrip(b" ")
    head = read_record(data, _Head, origin, remedy)
    if head.format != FORMAT:
        raise FileError(
            f"{origin} is not the header of a firstcontact recording: convert files of other "
            "programs with `firstcontact import`"
        )
    if head.version not in _VERSIONS:
        raise FileError(
            f"{origin} has format version {head.version!r}, but this program reads versions up to "
            f"{VERSION}: install the version of firstcontact that wrote the file"
        )
    return read_record(data, Header, origin, remedy)


@dataclass(frozen=True, slots=True)
class PinchMark:
    """Position of a pinch in a recording, with its labels and contacts.

    Parameters
    ----------
    number
        Number of the pinch in the recording, from 0. A missing number shows that a mark was lost.
    first_sample, end, epoch
        Device sample numbers of the pinch's first sample, and of the first sample after the pinch.
        Both belong to this epoch (run of the device's sample counter).
    label, truth
        Label of the pinched object, and true contacts in time order.
    motor_start
        Device sample number at which the motor starts to close the hand; None if unknown.
    found, found_by
        Contacts that a detector reported during the recording, as hints for labelling, and the
        detector's name.
    closing_speed
        Speed of the fingertip before the first contact, as the hand measured it; None if unknown.

    Raises
    ------
    InputError
        The pinch has no samples, or its contacts or motor start lie outside it.
    """

    number: Count
    first_sample: Sample
    end: Sample
    epoch: Epoch = 0
    label: Label = field(default_factory=Label)
    truth: Annotated[tuple[Contact, ...], Meta(max_length=len(Finger))] = ()
    motor_start: Sample | None = None
    found: Annotated[tuple[Contact, ...], Meta(max_length=len(Finger))] = ()
    found_by: Name = ""
    closing_speed: ClosingSpeed | None = None

    def __post_init__(self) -> None:
        if self.end <= self.first_sample:
            raise ArgumentError(
                f"the end is {self.end}, but the pinch begins at sample {self.first_sample}: give "
                "a later end",
                "end",
            )
        check_contacts(self.first_sample, self.end, self.truth, self.motor_start, self.found)

    def to_json(self) -> dict[str, Any]:
        tree = asdict(self)
        for name in ("truth", "found"):
            contacts = getattr(self, name)
            tree[name] = [{"finger": c.finger, "sample": c.sample} for c in contacts]
        return {k: v for k, v in tree.items() if k == "truth" or v not in (None, [], "")}


def read_mark(data: bytes, origin: str) -> PinchMark:
    return read_record(data, PinchMark, origin, "mark the pinch again", LONGEST_MARK)


@dataclass(frozen=True, slots=True)
class Marker:
    """Text that a person or device attached to a sample, given by its number and epoch."""

    sample: Sample
    text: Annotated[str, Meta(max_length=LONGEST_TEXT)]
    epoch: Epoch = 0


def read_marker(data: bytes, origin: str) -> Marker:
    return read_record(data, Marker, origin, "mark the sample again", LONGEST_MARK)


def block_schema(dtype: str) -> bytes:
    """Return the ROS 2 schema of messages whose samples have the NumPy type ``dtype``."""
    return f"uint64 first_sample\nuint32 epoch\nuint16 channels\n{dtype}[] data\n".encode()


def block_message(block: Block, dtype: str) -> bytes:
    """Encode a block as a message. The data of the block must already have the type ``dtype``."""
    values = np.ascontiguousarray(block.data, dtype=DTYPES[dtype])
    head = (block.first_sample, block.epoch, values.shape[1], values.size)
    return _PREFIX.pack(_CDR_LITTLE_ENDIAN, *head) + values.tobytes()


def read_block(data: bytes, dtype: str) -> Block:
    """Decode the block in a message. The block's samples are a view of the bytes ``data``."""
    if len(data) < _PREFIX.size:
        raise ValueError("a message with samples is too short")
    kind, first_sample, epoch, channels, count = _PREFIX.unpack_from(data)
    values: NDArray[np.generic] = np.frombuffer(data, DTYPES[dtype], offset=_PREFIX.size)
    if kind != _CDR_LITTLE_ENDIAN or not channels or values.size != count or count % channels:
        raise ValueError("a message with samples has another length than it declares")
    return Block(values.reshape(-1, channels), first_sample, epoch)
