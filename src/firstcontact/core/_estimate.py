"""Stiffness estimate of one closing: a live event, and what a grasp policy acts on."""

from __future__ import annotations

import msgspec

from firstcontact.core._pinch import Contact


class Estimate(msgspec.Struct, frozen=True, kw_only=True, tag="estimate"):
    """Predicted stiffness of the object that the first finger touched.

    Parameters
    ----------
    value
        Shore A, a hardness rank, or the class.
    low, high
        Ends of the interval; equal to the value for a model without an interval.
    level
        Share of intervals that hold the truth, on objects like the training objects; 0 without an
        interval.
    elapsed
        Length of the signal after the contact that was used, s.
    available
        Time from the contact until the estimate was available, s. It is the time until the signal
        and the contact were known, plus ``waited``, ``transport`` and ``compute``.
    out_of_range
        True where the contact is unlike the training data: the interval may not hold.
    final
        True where no better estimate of this closing comes.
    in_time
        True if it was available before the second contact; null until that is known, and for
        samples that do not come in real time.
    model
        Name of the estimator; on a device that predicts by itself the digest of its model.
    contact
        First contact of the closing.
    complete
        Sample after which the signal and the contact were known.
    epoch
        Epoch of the samples.
    host
        Time at which the estimate was made, s of the host's monotonic clock.
    compute
        Time from the arrival of the block to the estimate, s.
    waited
        Time that the sample ``complete`` waited for the rest of its block, and in the filter of the
        source, s of the device's clock.
    transport
        Delay of the block beyond the least delayed one of the last ten seconds, s.
    shape
        Shape that was given for the object, ``flat`` or ``radius 37 mm``; empty without one.
    half_width
        Half width of the interval before it was cut off at the ends of the scale; null for a model
        whose estimates are not combined over pinches.
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
    half_width: float | None = None

    @property
    def known_sample(self) -> int:
        """Sample with which the event was known."""
        return self.complete
