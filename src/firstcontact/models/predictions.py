"""Predictions of stiffness, and the pooled prediction from several pinches of one object."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import nan
from typing import TYPE_CHECKING, Any, Protocol, Self

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Contact, finger_name
from firstcontact.core.display import Drawable
from firstcontact.core.installation import require_modules
from firstcontact.core.quantity import QUANTITIES
from firstcontact.models.interval import SHORE_A
from firstcontact.models.touches import Touches
from firstcontact.models.values import Values

if TYPE_CHECKING:
    from pandas import DataFrame


@dataclass(frozen=True, slots=True, eq=False)
class Predictions(Drawable):
    """Predicted stiffness with interval, one per pinch or contact; NaN stands for no prediction.

    Parameters
    ----------
    value
        Predicted value in the unit of ``target``, or class, shape (n,).
    spread
        Predicted standard deviation of each value, shape (n,); NaN if the model predicts none.
    low, high
        Ends of the interval in the same unit, shape (n,); equal to the value without an interval.
    out_of_range
        True for contacts unlike the training data, shape (n,). Window models do not set it.
    elapsed
        Length of the signal after the contact that the prediction used, s, shape (n,).
    contacts
        First contact of each pinch, in the sample numbers of the predicted data (None without
        one); empty if the predictions were made from :class:`Touches` instead of pinches.
    estimator
        Name of the estimator that predicted; "" for predictions from :class:`Touches`.
    target
        Meaning of ``value``: "shore_a", "modulus_mpa", "stiffness_n_per_mm" or "hardness_rank"; ""
        as for ``estimator``.

    Examples
    --------
    >>> import firstcontact as fc
    >>> data = fc.load("recordings")
    >>> predictions: fc.Predictions = fc.adapt().predict(data[:2], at=0.003)
    >>> predictions.elapsed.round(3).tolist()
    [0.003, 0.003]
    """

    value: Values
    spread: Values
    low: Values
    high: Values
    out_of_range: NDArray[np.bool_]
    elapsed: Values
    contacts: Sequence[Contact | None] = ()
    estimator: str = ""
    target: str = ""

    def __len__(self) -> int:
        return len(self.value)

    def __repr__(self) -> str:
        """Return the number of predictions, their median and the estimator, without the arrays."""
        made = self.value[~np.isnan(self.value)]
        unit = f" {QUANTITIES[self.target].unit}" if self.target in QUANTITIES else ""
        median = f", median {np.median(made):.3g}{unit}" if len(made) else ""
        by = f" by {self.estimator!r}" if self.estimator else ""
        return f"Predictions({len(made)} of {len(self)} pinches{median}{by})"

    def to_frame(self) -> DataFrame:
        """Return a pandas table, one row for each prediction.

        ``value``, ``spread``, ``low`` and ``high`` have the unit of the target, usually Shore A.
        """
        require_modules("notebook", "pandas")
        from pandas import DataFrame

        value, spread, low, high, is_out, elapsed = self.columns
        frame = DataFrame({"value": value, "spread": spread, "low": low, "high": high})
        frame["out_of_range"], frame["elapsed_ms"] = is_out, 1e3 * elapsed
        if self.contacts:
            frame["finger"] = [c and finger_name(c.finger) for c in self.contacts]
            frame["contact_sample"] = [nan if c is None else c.sample for c in self.contacts]
        return frame

    @property
    def columns(self) -> tuple[NDArray[Any], ...]:
        """Tuple of value, spread, low, high, out_of_range and elapsed, arrays of shape (n,)."""
        return self.value, self.spread, self.low, self.high, self.out_of_range, self.elapsed

    @classmethod
    def empty(cls, contacts: Sequence[Contact | None]) -> Self:
        """Return a prediction for each of these contacts, all NaN, to be filled by :meth:`put`."""
        value, spread, low, high, elapsed = (np.full(len(contacts), nan) for _ in range(5))
        is_out = np.zeros(len(contacts), np.bool_)
        return cls(value, spread, low, high, is_out, elapsed, contacts)

    def put(self, rows: NDArray[Any], predictions: Predictions) -> None:
        """Overwrite the predictions in ``rows``, which are positions or a boolean mask."""
        for column, new in zip(self.columns, predictions.columns, strict=True):
            column[rows] = new

    def put_one(self, row: int, prediction: Sequence[float], elapsed: float) -> None:
        """Overwrite the prediction in one row, rounded to float32 as in C.

        ``prediction`` has the fields of :class:`firstcontact.models.anytime.Prediction`.
        ``elapsed`` is the length of the signal after the contact, s.
        """
        value, low, high, _, spread, is_out = prediction
        numbers = (
            *np.array([value, spread, low, high], np.float32).tolist(),
            bool(is_out),
            elapsed,
        )
        for column, number in zip(self.columns, numbers, strict=True):
            column[row] = number

    def take(self, rows: NDArray[Any]) -> Predictions:
        """Return the predictions in these rows (positions or a boolean mask), without contacts."""
        return _of_columns([column[rows] for column in self.columns], ())


class TouchPredictor(Protocol):
    """Interface of models that predict stiffness from several contacts in one call."""

    def predict_touches(self, touches: Touches) -> Predictions:
        """Return one prediction per contact, from the samples before the second contact."""
        ...


def _of_columns(columns: list[Any], contacts: Sequence[Contact | None]) -> Predictions:
    value, spread, low, high, out_of_range, elapsed = columns
    return Predictions(value, spread, low, high, out_of_range, elapsed, contacts)


#: Share of a pinch's error that all pinches of the object have in common, as a standard deviation:
#: the contribution of specimen, label, session and rig. Measured by ``firstcontact pretrain`` on
#: random rigs outside the training, with 5 pinches of each object in one session ("same object" in
#: the network's card): 0.90 at 3 to 15 ms.
SHARED = 0.89


@dataclass(frozen=True, slots=True)
class Combined:
    """Average of the predictions for several pinches of one object, with its interval, Shore A."""

    value: float
    low: float
    high: float
    half_width: float
    pinches: int


def combine(values: Sequence[float], half_widths: Sequence[float]) -> Combined:
    """Average the predictions for several pinches of one object, in Shore A.

    Each prediction is weighted by the inverse square of its interval's half width. The interval of
    the average counts the error that all pinches of an object share.
    """
    value, half = np.asarray(values, np.float64), np.asarray(half_widths, np.float64)
    weight = half**-2
    mean = float(weight @ value / weight.sum())
    n = len(value)
    single = n / weight.sum()
    width = float(np.sqrt(single * (SHARED**2 + (1 - SHARED**2) / n)))
    least, most = SHORE_A
    low, high = (min(max(mean + sign * width, least), most) for sign in (-1, 1))
    return Combined(mean, low, high, width, n)
