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
        """Those of a dataset; ``contacts`` are the first of its pinches, None where none is."""
        touches, which = touches_of(dataset, contacts)
        labelled = np.isfinite(dataset.shore_a[which])
        which = which[labelled]
        return cls(
            touches.take(labelled),
            dataset.shore_a[which],
            which,
            dataset.sessions[which],
            distinct_specimens(dataset)[which],
        )

    def take(self, which: NDArray[Any]) -> LabelledTouches:
        """Those at these positions, or where a mask is true."""
        arrays = [getattr(self, f.name)[which] for f in fields(self)[1:]]
        return LabelledTouches(self.touches.take(which), *arrays)

    @property
    def named_sessions(self) -> NDArray[np.str_] | None:
        """The sessions, where there are several and all have a name."""
        several = len(np.unique(self.sessions)) > 1 and (self.sessions != "").all()
        return self.sessions if several else None

    @property
    def clusters(self) -> NDArray[np.str_]:
        """What is alike: the specimen, or the pinch by itself where that is not named."""
        return np.where(self.specimens == "", self.which.astype(np.str_), self.specimens)
