"""Stiffness estimate of one contact: a live event, and the input of grasp policies."""

from __future__ import annotations

import msgspec

from firstcontact.core.pinch import Contact
from firstcontact.core.quantity import MODULUS, QUANTITIES, SHORE_A, modulus_of_shore_a


class Estimate(msgspec.Struct, frozen=True, kw_only=True, tag="estimate"):
    """Predicted stiffness of the touched object, reported while the hand closes (a live event).

    Parameters
    ----------
    value
        Predicted stiffness, in the unit of ``quantity``.
    low, high
        Ends of the prediction interval; both equal ``value`` for a model without an interval.
    level
        Nominal coverage: share of intervals that should contain the true value, such as 0.9. It
        holds for contacts that are like the training data. 0 without an interval.
    elapsed
        Duration of the signal after the contact from which ``value`` is predicted, s.
    available
        Time from the contact until the program had the estimate, s: the time from the contact to
        the sample ``complete``, plus ``waited``, ``transport`` and ``compute``.
    out_of_range
        True if the contact is unlike the training data. The interval is then not reliable.
    final
        True for the event that repeats, as the result, the last estimate whose samples all lie
        before the second contact. A contact has at most one. It is late, because the program must
        first rule out a second contact among these samples: let a hand act on earlier estimates.
    in_time
        True if the estimate was available before the second finger touched. None (null in JSON)
        until the second contact is known or the pinch is finished, and without real-time samples.
    model
        Name of the estimator. If a device predicts by itself, the digest of its model.
    contact
        First contact of the closing (one movement of the hand onto an object).
    complete
        Device number of the last sample needed to detect the contact and to predict ``value``.
    epoch
        Epoch of the samples: each restart of the device's sample counter begins a new epoch.
    host
        Time at which the estimate was made, on the host's monotonic clock, s.
    compute
        Computing time on the host, from the arrival of the block to the estimate, s.
    waited
        Time that the sample ``complete`` spent in the source's filter and waiting for the rest of
        its block, s.
    transport
        Extra delay of the block on its way to the host, compared with the least delayed block of
        the last ten seconds, s.
    shape
        Shape hint of the user for the object: "flat", "radius 37 mm", or "" without a hint.
    quantity
        Quantity of ``value``, as in the training labels: "shore_a" (hardness, 0 to 100),
        "modulus_mpa", "stiffness_n_per_mm" or "hardness_rank".
    modulus_mpa
        Young's modulus of an elastomer with this Shore A, MPa. Null for another quantity, and where
        Gent's formula does not hold.
    half_width
        Half width of the interval before it was clipped to the scale of ``value``. None (null in
        JSON) if the model's estimates are not averaged over several pinches of an object.
    """

    value: float
    low: float
    high: float
    level: float
    elapsed: float
    available: float
    out_of_range: bool = False
    final: bool = False
    in_time: bool | None = None
    model: str
    contact: Contact
    complete: int
    epoch: int
    host: float
    compute: float
    waited: float = 0.0
    transport: float = 0.0
    shape: str = ""
    quantity: str = SHORE_A.name
    modulus_mpa: float | None = None
    half_width: float | None = None

    def __post_init__(self) -> None:
        if self.quantity == SHORE_A.name:
            msgspec.structs.force_setattr(self, "modulus_mpa", modulus_of_shore_a(self.value))

    @property
    def words(self) -> str:
        """Value and interval with their unit: "29.0 Shore A (25 to 33), 1.1 MPa"."""
        words = QUANTITIES[self.quantity].words(self.value, self.low, self.high)
        modulus = self.modulus_mpa
        return words if modulus is None else f"{words}, {MODULUS.words(modulus)}"

    @property
    def known_sample(self) -> int:
        """Number, in the device's count, of the last sample that this event needed.

        Equal to ``complete``.
        """
        return self.complete
