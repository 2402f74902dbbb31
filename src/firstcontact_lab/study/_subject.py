"""Subject of a study: a dataset, with those results of its parts that later parts use."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Contact, Dataset
from firstcontact.models import Adapted, LabelledWindows, Windows, distinct_specimens, label_windows
from firstcontact.signal import contact_windows

Values = NDArray[np.float64]
Contacts = tuple[Contact | None, ...]
#: Windows, and a mask of the pinches that have a window.
Cut = tuple[Windows, NDArray[np.bool_]]


@dataclass(slots=True, eq=False)
class Subject:
    """Dataset under study, with the results of earlier parts."""

    name: str
    dataset: Dataset
    detections: Contacts = ()
    predictions: dict[tuple[str, str], tuple[LabelledWindows, Values]] = field(default_factory=dict)
    set_name: str = "recordings"
    adapted: Adapted | None = None
    _cut: dict[tuple[object, ...], Cut] = field(default_factory=dict, repr=False)

    @property
    def truth(self) -> Contacts:
        """First contact of each pinch from strips or labels; None if unknown."""
        return tuple(p.first for p in self.dataset.pinches)

    @property
    def has_known_contacts(self) -> bool:
        """True if the first contact of some pinch is known from strips or labels."""
        return any(contact is not None for contact in self.truth)

    @property
    def starts(self) -> Contacts:
        """Contacts at which windows start: detected contacts if there are any, else known ones."""
        return self.detections or self.truth

    @property
    def levels(self) -> Values:
        """Distinct values of Shore A in the training pinches."""
        shore = self.dataset.shore_a[~self.dataset.test]
        return np.unique(shore[np.isfinite(shore)])

    def windows(self, duration: float, contacts: Contacts | None = None) -> LabelledWindows:
        """Return windows labelled with Shore A, at ``contacts`` or else at :attr:`starts`."""
        return self.labelled_windows(duration, self.dataset.shore_a, contacts)

    def labelled_windows(
        self,
        duration: float,
        target: Values,
        contacts: Contacts | None = None,
        *,
        conditioned: bool = True,
    ) -> LabelledWindows:
        """Return windows at ``contacts``, or else at :attr:`starts`, labelled with ``target``."""
        cut = self.cut_windows(duration, contacts, conditioned=conditioned)
        data = label_windows(self.dataset, *cut, target)
        return replace(data, specimens=distinct_specimens(self.dataset)[data.rows])

    def cut_windows(
        self, duration: float, contacts: Contacts | None = None, *, conditioned: bool = True
    ) -> Cut:
        """Return the windows at ``contacts`` (default :attr:`starts`), and a mask of pinches."""
        starts = self.starts if contacts is None else contacts
        key = duration, conditioned, tuple(starts)
        if key not in self._cut:
            self._cut[key] = contact_windows(
                self.dataset, starts, duration, conditioned=conditioned
            )
        return self._cut[key]
