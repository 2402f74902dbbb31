"""Contacts with things of known Shore A, as they go on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Contact, Dataset
from firstcontact.models._touches import Touches, touches_of
from firstcontact.models._training import distinct_specimens

Values = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class LabelledTouches:
    """Contacts with a Shore A; all arrays share their first axis.

    Parameters
    ----------
    touches
        The contacts.
    shore_a
        Of what was touched, shape (n,).
    which
        Their pinches' positions in the dataset, shape (n,).
    sessions, specimens
        "" where none is named, shape (n,).
    """

    touches: Touches
    shore_a: Values
    which: NDArray[np.intp]
    sessions: NDArray[np.str_]
    specimens: NDArray[np.str_]

    def __len__(self) -> int:
        return len(self.touches)

    @classmethod
    def of(cls, dataset: Dataset, contacts: Sequence[Contact | None]) -> LabelledTouches:
        """Return the labelled contacts of a dataset, given each pinch's first contact."""
        touches, rows = touches_of(dataset, contacts)
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
        """Return the rows at these positions, or where a mask is true."""
        arrays = [getattr(self, f.name)[rows] for f in fields(self)[1:]]
        return LabelledTouches(self.touches.take(rows), *arrays)

    @property
    def named_sessions(self) -> NDArray[np.str_] | None:
        """The sessions, where there are several and all have a name."""
        several = len(np.unique(self.sessions)) > 1 and (self.sessions != "").all()
        return self.sessions if several else None

    @property
    def clusters(self) -> NDArray[np.str_]:
        """Return the cluster of each: its specimen, or the pinch itself if that has no name."""
        return np.where(self.specimens == "", self.which.astype(np.str_), self.specimens)
