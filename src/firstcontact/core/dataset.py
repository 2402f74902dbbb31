"""Dataset: a sequence of pinches, with their labels as arrays."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from math import nan
from typing import TYPE_CHECKING, Any, overload

import numpy as np
from numpy.typing import NDArray

from firstcontact.core._errors import ArgumentError
from firstcontact.core.display import Drawable
from firstcontact.core.installation import require_modules
from firstcontact.core.layout import Layout, finger_name
from firstcontact.core.pinch import Contact, Pinch, Role
from firstcontact.core.quantity import PHYSICAL, QUANTITIES, RANK, Quantity, shore_a_of_modulus
from firstcontact.core.text import counted

if TYPE_CHECKING:
    from pandas import DataFrame


@dataclass(frozen=True, slots=True, eq=False)
class Dataset(Drawable):
    """Sequence of pinches (closings of the hand) with one layout, and their labels as arrays.

    Iterate to get pinches. Index with an integer to get a pinch, and with a slice, a list of
    integers or a boolean mask to get a dataset.

    Parameters
    ----------
    pinches
        Pinches that share one layout.
    source
        Origin of the data: "twin" (simulated hand), "real", "synthetic" or "unknown".
    notes
        Sentences about loading and processing, such as resampling and skipped data.
    recorded_rate
        Sampling rate before resampling, Hz; None if the pinches were not resampled.
    losses
        Sentences about files, and parts of files, that could not be used.
    sessions_assumed
        True if an importer treated pinches without a session name as one session.

    Examples
    --------
    >>> import numpy as np
    >>> import firstcontact as fc
    >>> from firstcontact.core import fingertip_layout
    >>> layout = fingertip_layout()
    >>> shores = (10.0, 10.0, 60.0)
    >>> pinches = [fc.Pinch(np.zeros((500, 16)), layout, fc.Label(shore_a=s)) for s in shores]
    >>> data = fc.Dataset(tuple(pinches))
    >>> len(data), data[0].label.shore_a, len(data[1:]), len(data[data.shore_a > 50])
    (3, 10.0, 2, 1)
    """

    pinches: tuple[Pinch, ...]
    source: str = "unknown"
    notes: tuple[str, ...] = ()
    recorded_rate: float | None = None
    losses: tuple[str, ...] = ()
    sessions_assumed: bool = False

    def __len__(self) -> int:
        return len(self.pinches)

    def __iter__(self) -> Iterator[Pinch]:
        """Iterate over the pinches in order."""
        return iter(self.pinches)

    @overload
    def __getitem__(self, index: int | np.integer[Any]) -> Pinch: ...

    @overload
    def __getitem__(self, index: slice | NDArray[Any] | Sequence[int]) -> Dataset: ...

    def __getitem__(
        self, index: int | np.integer[Any] | slice | NDArray[Any] | Sequence[int]
    ) -> Pinch | Dataset:
        """Return the pinch at an index, or the dataset that a slice, list or mask selects."""
        if isinstance(index, int | np.integer):
            return self.pinches[index]
        return self.take(index)

    def __repr__(self) -> str:
        """Return a text with the numbers of pinches, objects and sessions, rate and source."""
        if not self.pinches:
            return f"Dataset(0 pinches, source={self.source!r})"
        labels = {"object": self.objects, "session": self.sessions}
        counts = [counted(len(set(names.tolist()) - {""}), noun) for noun, names in labels.items()]
        return (
            f"Dataset({counted(len(self), 'pinch')}, {', '.join(counts)}, {self.layout.rate:g} Hz, "
            f"source={self.source!r})"
        )

    def to_frame(self) -> DataFrame:
        """Return labels, contacts and closing speeds as a pandas DataFrame, one row per pinch.

        Columns are the fields of :class:`~firstcontact.Label` and ``length_ms``, ``first_finger``,
        ``first_contact_ms``, ``second_contact_ms`` (both from the first sample of the pinch) and
        ``closing_speed_mm_s``. Unknown numbers are NaN. Raises InputError without pandas.
        """
        require_modules("notebook", "pandas")
        from pandas import DataFrame

        def ms(pinch: Pinch, contact: Contact | None) -> float:
            at = nan if contact is None else contact.sample - pinch.first_sample
            return 1e3 * at / pinch.layout.rate

        rows = [
            {
                **asdict(pinch.label),
                "length_ms": 1e3 * len(pinch.data) / pinch.layout.rate,
                "first_finger": finger_name(pinch.first.finger) if pinch.first else None,
                "first_contact_ms": ms(pinch, pinch.first),
                "second_contact_ms": ms(pinch, pinch.second),
                "closing_speed_mm_s": 1e3 * pinch.closing_speed.speed
                if pinch.closing_speed
                else nan,
            }
            for pinch in self
        ]
        return DataFrame(rows).astype(dict.fromkeys(QUANTITIES, float)) if rows else DataFrame()

    @property
    def layout(self) -> Layout:
        """Layout that all pinches share."""
        return self.pinches[0].layout

    @property
    def quantity(self) -> Quantity | None:
        """Quantity that the labels state, such as Shore A or N/mm; None without such labels.

        Raises
        ------
        InputError
            The labels state more than one of Shore A, Young's modulus and stiffness.
        """
        stated = [q for q in QUANTITIES.values() if np.isfinite(self.label_values(q)).any()]
        measured = [q.name for q in stated if q in PHYSICAL]
        if len(measured) > 1:
            raise ArgumentError(
                f"the labels state {' and '.join(measured)}: give one of them in all pinches",
                parameter="data",
            )
        return stated[0] if stated else None

    def label_values(self, quantity: Quantity) -> NDArray[np.float64]:
        """Return the value of one quantity in each pinch's label, such as the Shore A.

        The array has the shape (pinches,) and the unit of ``quantity``. It is NaN where the label
        does not state this quantity.
        """
        return np.array([getattr(p.label, quantity.name) for p in self.pinches], dtype=np.float64)

    @property
    def shore_a(self) -> NDArray[np.float64]:
        """Shore A hardness of the object in each pinch, NaN if unknown, shape (pinches,).

        A Young's modulus in a label is converted by Gent's formula. Outside 5 to 90 Shore A, where
        the formula does not hold, the value is NaN.
        """
        labels = (p.label for p in self.pinches)
        return np.array(
            [shore_a_of_modulus(n.modulus_mpa) if n.shore_a is None else n.shore_a for n in labels],
            dtype=np.float64,
        )

    @property
    def hardness_rank(self) -> NDArray[np.float64]:
        """Hardness rank of the object in each pinch, NaN if unknown, shape (pinches,)."""
        return self.label_values(RANK)

    @property
    def objects(self) -> NDArray[np.str_]:
        """Name of the object in each pinch, "" if unknown, shape (pinches,)."""
        return np.array([p.label.object for p in self.pinches], dtype=np.str_)

    @property
    def specimens(self) -> NDArray[np.str_]:
        """Name of the specimen (one physical object) in each pinch, shape (pinches,)."""
        return np.array([p.label.specimen for p in self.pinches], dtype=np.str_)

    @property
    def sessions(self) -> NDArray[np.str_]:
        """Name of each pinch's recording session, "" if unknown, shape (pinches,)."""
        return np.array([p.label.session for p in self.pinches], dtype=np.str_)

    @property
    def test(self) -> NDArray[np.bool_]:
        """Boolean mask: True for pinches with the role TEST (unseen objects), shape (pinches,)."""
        return np.array([p.label.role is Role.TEST for p in self.pinches], dtype=np.bool_)

    def take(self, positions: slice | NDArray[Any] | Sequence[int]) -> Dataset:
        """Return a dataset with the pinches that a slice, a list of integers or a mask selects."""
        if not isinstance(positions, slice):
            positions = np.asarray(positions, dtype=None if len(positions) else np.intp)
        chosen = np.arange(len(self))[positions]
        return replace(self, pinches=tuple(self.pinches[i] for i in chosen))
