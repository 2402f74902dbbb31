"""Stiffness estimate of one closing. It is a live event, and the input of grasp policies."""

from __future__ import annotations

import msgspec

from firstcontact.core.pinch import Contact


class Estimate(msgspec.Struct, frozen=True, kw_only=True, tag="estimate"):
    """Predicted stiffness of the object that the first finger touched.

    Parameters
    ----------
    value
        Predicted Shore A, hardness rank, or class.
    low, high
        Ends of the interval; equal to the value for a model without an interval.
    level
        Nominal coverage: share of intervals that should contain the true value. It holds for
        contacts that are like the training data. 0 without an interval.
    elapsed
        Length of the signal after the contact that the prediction uses, s.
    available
        Time from the contact until the estimate was available, s. It is the time until the signal
        and the contact were known, plus ``waited``, ``transport`` and ``compute``.
    out_of_range
        True if the contact is unlike the training data. The interval is then not reliable.
    final
        True if no better estimate of this closing follows.
    in_time
        True if the estimate was available before the second contact. It is null until the second
        contact is known or the pinch is finished, and for samples that do not come in real time.
    model
        Name of the estimator. If a device predicts by itself, the digest of its model.
    contact
        First contact of the closing.
    complete
        Number of the last sample that was needed for the estimate's signal and for its contact.
    epoch
        Epoch of the samples.
    host
        Time at which the estimate was made, s of the host's monotonic clock.
    compute
        Time from the arrival of the block to the estimate, s.
    waited
        Time, s of the device's clock, that the sample ``complete`` spent in the source's filter and
        waiting for the rest of its block.
    transport
        Delay of the block, s, beyond that of the least delayed block of the last ten seconds.
    shape
        Shape that was given for the object, ``flat`` or ``radius 37 mm``; empty without one.
    half_width
        Half width of the interval before it was clipped to the scale; null if the model's estimates
        are not pooled over pinches.
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
        """Number of the last sample that was needed to report this event."""
        return self.complete
