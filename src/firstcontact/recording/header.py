"""What a recording says about itself, and the marks made in it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from firstcontact.core import Calibration, Contact, Finger, Label, Layout

#: Name and version of the format; a reader refuses any other.
FORMAT = "firstcontact.recording"
VERSION = 1
#: Where samples can come from.
SOURCES = ("twin", "real", "synthetic")
#: Sample types a recording can hold, little-endian.
DTYPES = {"int16": "<i2", "int32": "<i4", "float32": "<f4"}


@dataclass(frozen=True, slots=True)
class Header:
    """What a recording says about itself. "" means not known.

    Parameters
    ----------
    layout
        The columns, their rate and units.
    source
        "twin", "real" or "synthetic".
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
    """

    layout: Layout
    source: str = "real"
    dtype: str = "int16"
    sensor: str = ""
    hand: str = ""
    firmware: str = ""
    session: str = ""
    notes: str = ""
    created: str = ""
    calibration: Calibration | None = None

    def __post_init__(self) -> None:
        if self.source not in SOURCES:
            raise ValueError(f"source is {self.source!r}, not one of {', '.join(SOURCES)}")
        if self.dtype not in DTYPES:
            raise ValueError(f"dtype is {self.dtype!r}, not one of {', '.join(DTYPES)}")

    def to_json(self) -> dict[str, Any]:
        """A JSON-ready form, with the name and version of the format."""
        tree = {"format": FORMAT, "version": VERSION, **asdict(self)}
        if self.calibration is None:
            del tree["calibration"]
        return {**tree, "layout": self.layout.to_json()}

    @classmethod
    def from_json(cls, tree: Mapping[str, Any]) -> Header:
        """The inverse of :meth:`to_json`."""
        fields = {k: v for k, v in tree.items() if k not in ("format", "version")}
        if "calibration" in fields:
            fields["calibration"] = Calibration.from_json(fields["calibration"])
        return cls(**{**fields, "layout": Layout.from_json(tree["layout"])})


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
    """

    number: int
    first_sample: int
    end: int
    epoch: int = 0
    label: Label = field(default_factory=Label)
    truth: tuple[Contact, ...] = ()
    motor_start: int | None = None

    def to_json(self) -> dict[str, Any]:
        """A JSON-ready form."""
        tree = {
            "number": self.number,
            "first_sample": self.first_sample,
            "end": self.end,
            "epoch": self.epoch,
            "label": self.label.to_json(),
            "truth": [{"finger": int(c.finger), "sample": c.sample} for c in self.truth],
        }
        if self.motor_start is not None:
            tree["motor_start"] = self.motor_start
        return tree

    @classmethod
    def from_json(cls, tree: Mapping[str, Any]) -> PinchMark:
        """The inverse of :meth:`to_json`."""
        truth = tuple(
            Contact(Finger(c["finger"]), int(c["sample"]), int(c["sample"])) for c in tree["truth"]
        )
        label = Label.from_json(tree["label"])
        return cls(
            tree["number"],
            tree["first_sample"],
            tree["end"],
            tree["epoch"],
            label,
            truth,
            tree.get("motor_start"),
        )


@dataclass(frozen=True, slots=True)
class Marker:
    """A word of the operator or of a device, pinned to a sample."""

    sample: int
    text: str
    epoch: int = 0
