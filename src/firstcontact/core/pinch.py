"""Pinches: samples, labels and contacts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from enum import StrEnum
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from msgspec import Meta
from numpy.typing import NDArray

from firstcontact.core._block import Block
from firstcontact.core._errors import ArgumentError
from firstcontact.core.calibration import Calibration
from firstcontact.core.display import Drawable
from firstcontact.core.given import brief, given_choice, given_name, given_number, given_whole
from firstcontact.core.layout import ChannelKind, Finger, Layout, finger_name
from firstcontact.core.physics import parse_radius
from firstcontact.core.quantity import MODULUS, QUANTITIES, RANK, SHORE_A, STIFFNESS, Quantity
from firstcontact.core.records import Name

if TYPE_CHECKING:
    pass

#: Bounds on closing speeds, m/s, far beyond those of any hand.
SLOWEST, FASTEST = 1e-4, 10.0


class Role(StrEnum):
    """Use of a pinch: to train models, or to test them on objects that were not in training."""

    TRAIN = "train"
    TEST = "test"


@dataclass(frozen=True, slots=True)
class Label:
    """Label of one pinch: the object and its hardness. None or "" in a field means unknown.

    Names are kept in one spelling: 1, "1.0" and " 01" are all "1", and a NaN name is unknown.

    Parameters
    ----------
    object
        Name of the object.
    shore_a
        Shore A hardness as a durometer reads it, 0 to 100.
    hardness_rank
        Rank by hardness of an object without a Shore A: a larger number is harder.
    specimen
        Name of one physical object, such as "apple 2", if several objects have the same name.
    session
        Name of the session, the pinches recorded without a change of the set-up. Cross-validation
        leaves out whole sessions.
    role
        ``TRAIN`` for pinches that train models, ``TEST`` for pinches that are only scored.
    shape
        Shape of the surface that the finger touches: "flat", or its radius, 5 to 200, in mm.
    modulus_mpa
        Young's modulus of the object, MPa, instead of a Shore A.
    stiffness_n_per_mm
        Stiffness of the object, N/mm, instead of a Shore A.

    Raises
    ------
    InputError
        A value is impossible for its field, such as a Shore A outside 0 to 100.
    """

    object: Name = ""
    shore_a: Annotated[float, Meta(ge=SHORE_A.least, le=SHORE_A.most)] | None = None
    hardness_rank: Annotated[int, Meta(ge=int(RANK.least), le=int(RANK.most))] | None = None
    specimen: Name = ""
    session: Name = ""
    role: Role = Role.TRAIN
    shape: Name = ""
    modulus_mpa: Annotated[float, Meta(ge=MODULUS.least, le=MODULUS.most)] | None = None
    stiffness_n_per_mm: Annotated[float, Meta(ge=STIFFNESS.least, le=STIFFNESS.most)] | None = None

    def __post_init__(self) -> None:
        for name in ("object", "specimen", "session", "shape"):
            object.__setattr__(self, name, given_name(getattr(self, name), name))
        parse_radius(self.shape)
        object.__setattr__(self, "role", given_choice(Role, self.role, "role"))
        for name, quantity in QUANTITIES.items():
            if (value := getattr(self, name)) is not None:
                remedy = f"{quantity.least:g} to {quantity.most:g}, or None if unknown"
                number = given_number(value, name, quantity.least, quantity.most, remedy)
                if quantity is RANK:
                    number = given_whole(value, name)
                object.__setattr__(self, name, number)

    @property
    def value(self) -> tuple[Quantity, float] | None:
        """Quantity that the label states, and its value in the unit of the quantity.

        None if the label states neither Shore A, modulus, stiffness nor rank.
        """
        known = ((q, getattr(self, name)) for name, q in QUANTITIES.items())
        return next(((q, value) for q, value in known if value is not None), None)

    @property
    def value_words(self) -> str:
        """Stated value with its unit, such as "40 Shore A"; "" if unknown."""
        return "" if self.value is None else self.value[0].label_words(self.value[1])

    def to_json(self) -> dict[str, Any]:
        """Return the label as a dict for JSON. An unknown shape, modulus or stiffness is absent."""
        optional = ("shape", MODULUS.name, STIFFNESS.name)
        return {k: v for k, v in asdict(self).items() if k not in optional or v not in ("", None)}


@dataclass(frozen=True, slots=True)
class Contact:
    """First touch of one finger in a closing, given in the device's sample numbers.

    ``sample`` is the first sample of the contact. ``decided`` is the last sample that the detector
    needed to detect it; by default ``sample``, as for labelled contacts. ``finger`` is None if the
    sensor belongs to no finger.
    """

    finger: Finger | None
    sample: int
    decided: int = -1

    def __post_init__(self) -> None:
        if self.finger is not None:
            object.__setattr__(self, "finger", given_choice(Finger, self.finger, "finger"))
        object.__setattr__(self, "sample", given_whole(self.sample, "sample"))
        decided = self.sample if self.decided == -1 else given_whole(self.decided, "decided")
        object.__setattr__(self, "decided", decided)


@dataclass(frozen=True, slots=True)
class ClosingSpeed:
    """Speed of the fingertip just before it touches, measured from positions of the hand.

    Parameters
    ----------
    speed
        Speed, m/s.
    error
        Standard error of the speed, m/s; 0 if the speed is exact.

    Raises
    ------
    InputError
        The speed is outside 0.1 mm/s to 10 m/s, or the error is outside 0 to 10 m/s.

    Examples
    --------
    >>> import firstcontact as fc
    >>> from dataclasses import replace
    >>> pinch = replace(fc.load("recordings")[0], closing_speed=fc.ClosingSpeed(0.13, 0.003))
    >>> pinch.closing_speed.speed
    0.13
    """

    speed: Annotated[float, Meta(ge=SLOWEST, le=FASTEST)]
    error: Annotated[float, Meta(ge=0, le=FASTEST)] = 0.0

    def __post_init__(self) -> None:
        for name, value, least in (("speed", self.speed, SLOWEST), ("error", self.error, 0.0)):
            remedy = f"{least:g} to {FASTEST:g} m/s"
            object.__setattr__(self, name, given_number(value, name, least, FASTEST, remedy))


def first_closed_sample(strip: NDArray[Any], first_sample: int = 0) -> int | None:
    """Return the number of the first sample at which a contact strip is closed.

    ``strip`` is 0 while open. ``first_sample`` is the device sample number of ``strip[0]``. Returns
    None if the strip stays open.
    """
    return first_sample + int(np.argmax(strip != 0)) if strip.any() else None


#: Types of the fields of a pinch that are records.
_RECORDS: Mapping[str, Any] = {
    "label": Label,
    "calibration": Calibration,
    "closing_speed": ClosingSpeed,
}


def check_contacts(
    first_sample: int,
    end: int,
    contacts: Sequence[Contact],
    motor_start: int | None = None,
    hints: Sequence[Contact] = (),
) -> None:
    """Raise ArgumentError if contacts or the motor start do not fit a pinch.

    A pinch has at most one contact of each finger, in time order. All must lie within the samples
    ``first_sample`` to ``end`` (exclusive), as must the contacts found by a detector, ``hints``.
    """
    samples = [c.sample for c in contacts]
    fingers = [c.finger for c in contacts if c.finger is not None]
    if samples != sorted(samples) or len(set(fingers)) < len(fingers):
        raise ArgumentError(
            "the contacts are not in time order, or two are of one finger: give at most one of "
            "each finger, in time order",
            "truth",
        )
    given = [("truth", sample) for sample in samples]
    given += [("found", contact.sample) for contact in hints]
    given += [] if motor_start is None else [("motor_start", motor_start)]
    for parameter, sample in given:
        if not first_sample <= sample < end:
            raise ArgumentError(
                f"{sample} is outside the pinch: count samples from the start of the device, so "
                f"give {first_sample} to {end - 1}",
                parameter,
            )


def _sample_array(data: Any, layout: Layout) -> NDArray[Any]:
    """Convert the samples of a pinch to an array. Masked samples become NaN.

    Raises ArgumentError unless ``data`` are numbers of shape (samples, layout.width).
    """
    if isinstance(data, np.ma.MaskedArray):
        masked = np.ma.getmaskarray(data)
        data = np.where(masked, np.nan, data.data) if masked.any() else data.data
    array = np.asarray(data)
    if array.ndim != 2 or array.shape[1] != layout.width or array.dtype.kind not in "iufb":
        raise ArgumentError(
            f"an array of {array.dtype}, shape {array.shape}, does not fit the layout: give "
            f"numbers, shape (samples, {layout.width})",
            parameter="data",
        )
    return array


@dataclass(frozen=True, slots=True, eq=False)
class Pinch(Drawable):
    """Samples and label of one pinch: the hand closes once on an object.

    Parameters
    ----------
    data
        Raw samples, shape (samples, channels).
    layout
        Meaning of the columns of ``data``, their units, and the sampling rate.
    label
        Label of the pinched object.
    first_sample
        Device sample number of ``data[0]``.
    truth
        True contacts, from the contact strips or from a person's labels, in time order: none, only
        the first, or one of each finger.
    motor_start
        Device sample number at which the motor starts to close the hand; None if unknown. Like
        ``first_sample``, it counts from the start of the device, not of the pinch.
    calibration
        Calibration of the fingertips from the recording; None without one.
    groups
        Samples of channels with a lower rate during the pinch, by name of their group. A group
        with missing samples is absent.
    closing_speed
        Speed of the fingertip before the first contact, as the hand measured it; None if unknown.

    Raises
    ------
    InputError
        The data, layout, contacts or labels do not fit together: for example, a contact lies
        outside the samples.

    Examples
    --------
    >>> import numpy as np
    >>> from firstcontact.core import fingertip_layout
    >>> first = Contact(Finger.THUMB, 120, 120)
    >>> pinch = Pinch(np.zeros((500, 16), np.int16), fingertip_layout(), truth=(first,))
    >>> pinch.first.finger.name, pinch.second
    ('THUMB', None)
    """

    data: NDArray[Any]
    layout: Layout
    label: Label = field(default_factory=Label)
    first_sample: int = 0
    truth: tuple[Contact, ...] = ()
    motor_start: int | None = None
    calibration: Calibration | None = None
    groups: Mapping[str, Block] = field(default_factory=dict)
    closing_speed: ClosingSpeed | None = None

    def __post_init__(self) -> None:
        if fault := self.layout.why_unusable:
            message = f"the layout has {fault}: give each finger one channel"
            raise ArgumentError(message, parameter="layout")
        object.__setattr__(self, "data", _sample_array(self.data, self.layout))
        object.__setattr__(self, "first_sample", given_whole(self.first_sample, "first_sample"))
        object.__setattr__(self, "truth", tuple(self.truth))
        if self.motor_start is not None:
            object.__setattr__(self, "motor_start", given_whole(self.motor_start, "motor_start"))
        end = self.first_sample + len(self.data)
        check_contacts(self.first_sample, end, self.truth)
        if self.motor_start is not None and self.motor_start > end:
            raise ArgumentError(
                f"{self.motor_start} is after the pinch: give at most {end}", "motor_start"
            )
        for name, kind in _RECORDS.items():
            if not isinstance(value := getattr(self, name), kind | None) or self.label is None:
                message = f"{brief(value)} is not a {kind.__name__}: make one"
                raise ArgumentError(message, parameter=name)

    @property
    def first(self) -> Contact | None:
        """Contact of the finger that touches first; None if unknown."""
        return self.truth[0] if self.truth else None

    @property
    def second(self) -> Contact | None:
        """Contact of the finger that touches second; None if unknown."""
        return self.truth[1] if len(self.truth) > 1 else None

    @property
    def offset(self) -> float | None:
        """Time from the first to the second contact, s; None if unknown."""
        if self.second is None:
            return None
        return (self.truth[1].sample - self.truth[0].sample) / self.layout.rate

    def __repr__(self) -> str:
        """Return a text with object, duration and first contact, without the samples."""
        first, rate = self.first, self.layout.rate
        parts = [self.label.object or "unknown object", f"{len(self.data) / rate * 1e3:.1f} ms"]
        if self.label.value is not None:
            parts.insert(1, self.label.value_words)
        if first is not None:
            at = (first.sample - self.first_sample) / rate * 1e3
            parts.append(f"{finger_name(first.finger)} first at {at:.1f} ms")
        return f"Pinch({', '.join(parts)})"

    def vibration(self) -> NDArray[np.float64]:
        """Return the vibration in physical units, shape (samples, vibration channels).

        Of a sensor with several axes, only the column of its
        :attr:`~firstcontact.core.Channel.axis` is returned.
        """
        return self.layout.physical(self.data, self.layout.columns(ChannelKind.VIBRATION))

    def force(self, finger: Finger) -> NDArray[np.float64]:
        """Return the signals of a finger's force cells (taxels), shape (samples, cells).

        They are in the unit of their channels: V for fingertips. :meth:`ForceCurve.newtons` of a
        calibration converts these to N.
        """
        return self.layout.physical(self.data, self.layout.columns(ChannelKind.FORCE, finger))

    def group(self, name: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return times and values of a group of channels with a lower rate.

        The times, shape (samples,), are in s from the pinch's first sample. The values, shape
        (samples, columns), are in physical units. Raises KeyError if the group is absent.
        """
        block = self.groups[name]
        layout = next(g.layout for g in self.layout.groups if g.name == name)
        times = (block.first_sample + np.arange(len(block.data))) / layout.rate
        values = layout.physical(block.data, tuple(range(layout.width)))
        return times - self.first_sample / self.layout.rate, values

    def strip(self, finger: Finger) -> NDArray[np.float64]:
        """Return a finger's contact strip, 0 without contact and 1 with it, shape (samples, 1)."""
        return self.layout.physical(self.data, self.layout.columns(ChannelKind.STRIP, finger))
