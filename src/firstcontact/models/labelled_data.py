"""Windows and contacts with their labels, to which models are fitted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import ArgumentError, Contact, Dataset, Label
from firstcontact.core.layout import FINGERTIP_WINDOW
from firstcontact.core.quantity import QUANTITIES, Quantity
from firstcontact.models.touches import Touches
from firstcontact.models.values import Values, Windows
from firstcontact.signal import contact_windows

#: Default length of a window, s.
DURATION = FINGERTIP_WINDOW


@dataclass(frozen=True, slots=True, eq=False)
class LabelledWindows:
    """Windows (signals cut after contacts) with targets and groups. Arrays have a row per window.

    Parameters
    ----------
    X
        Windows in V, shape (n, samples, 1).
    y
        Target: Shore A, a hardness rank or a class, shape (n,).
    sessions, specimens, objects
        Session, specimen and object of each window, shape (n,).
    test
        True for windows of pinches with role "test", shape (n,).
    rows
        Position of each window's pinch in the dataset, shape (n,).
    rate
        Sampling rate of the windows, Hz.
    """

    X: Windows
    y: Values
    sessions: NDArray[np.str_]
    specimens: NDArray[np.str_]
    objects: NDArray[np.str_]
    test: NDArray[np.bool_]
    rows: NDArray[np.intp]
    rate: float

    def __len__(self) -> int:
        return len(self.X)

    @property
    def has_sessions(self) -> bool:
        """True if the windows come from two or more sessions and all of these have names."""
        return _tells_apart(self.sessions)

    @property
    def named_sessions(self) -> NDArray[np.str_] | None:
        """Name of the session of each window, shape (n,); None if any session has no name."""
        return self.sessions if (self.sessions != "").all() else None

    @property
    def bootstrap_clusters(self) -> NDArray[np.str_]:
        """Name of the group with which the bootstrap draws each window, shape (n,).

        The group is a session, if there are two or more and all have names. Otherwise it is a
        specimen, if there are two or more and all have names, and else a single pinch.
        """
        return resampling_clusters(self.sessions, self.specimens)

    def take(self, rows: NDArray[np.intp] | NDArray[np.bool_]) -> LabelledWindows:
        """Return the windows in these rows, given as positions or a boolean mask."""
        arrays = {f.name: getattr(self, f.name)[rows] for f in fields(self) if f.name != "rate"}
        return replace(self, **arrays)


def resampling_clusters(
    sessions: NDArray[np.str_], specimens: NDArray[np.str_]
) -> NDArray[np.str_]:
    """Return the name of the group with which the bootstrap draws each pinch, shape (pinches,).

    It is a session, a specimen or a single pinch, see :attr:`LabelledWindows.bootstrap_clusters`.
    """
    for names in (sessions, specimens):
        if _tells_apart(names):
            return names
    return np.arange(len(sessions)).astype(np.str_)


def _tells_apart(names: NDArray[np.str_]) -> bool:
    return len(np.unique(names)) > 1 and bool((names != "").all())


def distinct_specimens(dataset: Dataset) -> NDArray[np.str_]:
    """Return the name of each pinch's specimen (physical object), shape (pinches,).

    A name that several objects share is followed by the object and its Shore A.
    """
    labels = [pinch.label for pinch in dataset.pinches]
    kinds: dict[str, set[tuple[str, ...]]] = {}
    for label in labels:
        kinds.setdefault(label.specimen, set()).add(_kind(label))
    names = [
        label.specimen if len(kinds[label.specimen]) == 1 else full_specimen(label)
        for label in labels
    ]
    return np.array(names, dtype=np.str_)


def full_specimen(label: Label) -> str:
    """Return a specimen's name followed by its object and label value, unique in the data."""
    return f"{label.specimen or 'unnamed'} ({', '.join(_kind(label)) or 'unknown'})"


def _kind(label: Label) -> tuple[str, ...]:
    level = "" if label.value is None else f"{label.value[1]:g}"
    return tuple(s for s in (label.object, level) if s)


def labelled_windows(
    dataset: Dataset, contacts: Sequence[Contact | None], duration: float, target: Values
) -> LabelledWindows:
    """Cut windows of ``duration`` (s) from pinches that have a contact and a target.

    ``contacts`` holds the first contact of each pinch, and ``target`` its target, NaN if unknown.
    Pinches without a complete window are left out.
    """
    return label_windows(dataset, *contact_windows(dataset, contacts, duration), target)


def label_windows(
    dataset: Dataset, X: Windows, has_window: NDArray[np.bool_], target: Values
) -> LabelledWindows:
    """Label windows that :func:`firstcontact.signal.contact_windows` has cut from a dataset.

    ``has_window`` is True for the pinches that a window was cut from. Windows without a ``target``
    (NaN) are left out.
    """
    has_target = np.isfinite(target[has_window])
    positions = np.flatnonzero(has_window)[has_target]
    return LabelledWindows(
        X[has_target],
        target[positions],
        dataset.sessions[positions],
        dataset.specimens[positions],
        dataset.objects[positions],
        dataset.test[positions],
        positions,
        dataset.layout.rate,
    )


def cut_windows(
    dataset: Dataset, contacts: Sequence[Contact | None], length: float, is_scaled: bool
) -> LabelledWindows:
    """Return the windows after contacts, ``length`` s, with the values that the labels state.

    ``is_scaled`` puts the values on the scale of their quantity. Raises ArgumentError for fewer
    than 2 windows.
    """
    quantity = stated_quantity(dataset)
    values = dataset.label_values(quantity)
    values = quantity.scaled(values) if is_scaled else values
    cut = labelled_windows(dataset, contacts, length, values)
    if len(cut) < 2:
        raise ArgumentError(
            f"only {len(cut)} of {len(dataset)} pinches have a contact, {1e3 * length:g} ms of "
            f"signal after it and a label {quantity.name}: record or import 2 or more such pinches",
            parameter="data",
        )
    return cut


def stated_quantity(dataset: Dataset) -> Quantity:
    """Return the quantity that the labels state. Raise InputError if it is none, or several."""
    if quantity := dataset.quantity:
        return quantity
    raise ArgumentError(
        f"no pinch has a label {', '.join(QUANTITIES)}: record or import pinches with one of them",
        parameter="data",
    )


@dataclass(frozen=True, slots=True, eq=False)
class LabelledTouches:
    """Contacts with objects of known Shore A. Each array has one row per contact.

    Parameters
    ----------
    touches
        Signals of the contacts.
    shore_a
        Shore A of the object, shape (n,).
    rows
        Positions of their pinches in the dataset, shape (n,).
    sessions, specimens
        Session and specimen of each contact, "" if unnamed, shape (n,).
    """

    touches: Touches
    shore_a: Values
    rows: NDArray[np.intp]
    sessions: NDArray[np.str_]
    specimens: NDArray[np.str_]

    def __len__(self) -> int:
        return len(self.touches)

    @classmethod
    def cut(cls, dataset: Dataset, contacts: Sequence[Contact | None]) -> LabelledTouches:
        """Cut the signals around contacts with objects of known Shore A.

        ``contacts`` holds the first contact of each pinch, None if unknown.
        """
        touches, rows = Touches.cut(dataset, contacts)
        labelled = np.isfinite(dataset.shore_a[rows])
        rows = rows[labelled]
        return cls(
            touches.take(labelled),
            dataset.shore_a[rows],
            rows,
            dataset.sessions[rows],
            distinct_specimens(dataset)[rows],
        )

    def take(self, rows: NDArray[Any]) -> LabelledTouches:
        """Return the contacts in these rows, given as positions or a boolean mask."""
        arrays = [getattr(self, f.name)[rows] for f in fields(self)[1:]]
        return LabelledTouches(self.touches.take(rows), *arrays)

    @property
    def named_sessions(self) -> NDArray[np.str_] | None:
        """Session of each contact, shape (n,); None if any has no name, or all are the same."""
        return self.sessions if _tells_apart(self.sessions) else None

    @property
    def bootstrap_clusters(self) -> NDArray[np.str_]:
        """Name of the group with which the bootstrap draws each contact, shape (n,).

        The group is a specimen, or a single pinch if the specimen has no name.
        """
        return np.where(self.specimens == "", self.rows.astype(np.str_), self.specimens)
