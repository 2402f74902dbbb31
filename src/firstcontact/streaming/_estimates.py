"""Estimates of one closing, without those that use samples after the second contact."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from msgspec.structs import replace

from firstcontact.core import Block, ClosingSpeed, Contact, Estimate, InputError, Layout
from firstcontact.models import in_words
from firstcontact.streaming._events import Event, NoEstimate, judged
from firstcontact.streaming._predictors import Prediction, Predictor


class ClosingEstimates:
    """Collector of the estimates of a closing, from any model, with blocks of any size.

    Parameters
    ----------
    predictor
        Model that predicts.
    layout
        Columns of the samples.
    clock
        Clock of the host, s.
    delay
        Delay of the source's own filter, s.
    radius
        Radius of the object, m: infinite for a flat object, NaN if unknown.
    real_time
        True if samples come as fast as they were taken.

    Attributes
    ----------
    estimates
        Estimates so far, from samples before the second contact. The last estimate is final once no
        further estimate can follow.
    reason
        Reason for a missing estimate, else "".
    """

    def __init__(
        self,
        predictor: Predictor,
        layout: Layout,
        clock: Callable[[], float],
        delay: float = 0.0,
        radius: float = math.nan,
        *,
        real_time: bool = True,
    ) -> None:
        self._stream = predictor.start(layout, radius, real_time=real_time)
        self._model = predictor.name
        self._clock, self._delay, self._rate = clock, delay, layout.rate
        self._shape = in_words(radius)
        self._real_time = real_time
        self._first: Contact | None = None
        self._second: Contact | None = None
        self._is_settled = False
        self._made: list[tuple[int, Estimate]] = []  # with the last sample that each depends on
        self._failure = ""
        self._unheard: list[Block] = []  # samples of the contact that the stream did not take
        self.reason = ""

    @property
    def estimates(self) -> tuple[Estimate, ...]:
        """Estimates so far, from samples before the second contact."""
        return tuple(estimate for _, estimate in self._made)

    @property
    def due(self) -> int | None:
        """Number of further samples until the next estimate; None if no estimate can follow."""
        return None if self._second is not None or self._is_settled else self._stream.due

    def prepare(self) -> None:
        """Prepare the next estimate. Call this once the events of a block were delivered."""
        if self.due is not None:
            self._stream.prepare()

    def set_speed(self, measured: ClosingSpeed | None) -> None:
        """Set the closing speed before the first contact.

        Call this before the :meth:`update` that gets this contact.
        """
        self._stream.set_speed(measured)

    def withdraw(self) -> None:
        """Discard the first contact and its estimates. Another contact may follow."""
        self._first = self._second = None
        self._is_settled = False
        self._made = []
        self._failure = self.reason = ""
        self._stream.withdraw()
        unheard, self._unheard = self._unheard, []
        for block in unheard:
            list(self._stream.update(block, None))

    def update(
        self, block: Block, contacts: Sequence[Contact], host: float, transport: float
    ) -> list[tuple[int, Event]]:
        """Process the next samples.

        Parameters
        ----------
        block
            Samples of the closing.
        contacts
            Contacts of the closing that are known by the end of the block.
        host
            Time at which the block's last byte had been read, s.
        transport
            Delay of the block, compared with the least delayed blocks, s.

        Returns
        -------
        list of (int, Event)
            Events, each with the sample after which it was known.
        """
        first = contacts[0] if contacts and self._first is None else None
        self._first = self._first or first
        second = contacts[1] if len(contacts) > 1 and self._second is None else None
        events: list[tuple[int, Event]] = []
        if self._second is None and not self._stream.ended:
            predictions = []
            try:
                for prediction in self._stream.update(block, first):
                    predictions.append(prediction)
            except InputError as error:
                self._failure = str(error)
            if self._first is not None:
                events += self._make(predictions, self._first, second, block, host, transport)
        else:
            self._unheard.append(block)
        if second is not None and self._first is not None:
            self._second = second
            events += self._stop(self._first, second, block.epoch)
        return events

    def _make(
        self,
        predictions: Sequence[Prediction],
        first: Contact,
        second: Contact | None,
        block: Block,
        host: float,
        transport: float,
    ) -> list[tuple[int, Event]]:
        """Return the new estimates, each with the sample after which it was known.

        Estimates from samples after the second contact are left out. If no estimate can follow, the
        last one is returned once more, marked as final.
        """
        now = self._clock() if predictions else 0.0
        events: list[tuple[int, Event]] = []
        is_complete = True
        for p in predictions:
            complete = max(p.complete, first.decided)
            if (
                second is not None
                and complete >= second.decided
                and not _stands(p.complete, second)
            ):
                is_complete = False  # smaller blocks would not give it
                continue
            waited = (block.end - 1 - complete) / self._rate + self._delay
            estimate = Estimate(
                value=p.value,
                low=p.low,
                high=p.high,
                level=p.level,
                elapsed=p.elapsed,
                available=(complete - first.sample) / self._rate
                + waited
                + transport
                + (now - host),
                out_of_range=p.out_of_range,
                model=self._model,
                contact=first,
                complete=complete,
                epoch=block.epoch,
                host=now,
                compute=now - host,
                waited=waited,
                transport=transport,
                shape=self._shape,
                half_width=p.half_width,
            )
            self._made.append((p.complete, estimate))
            events.append((complete, estimate))
        if self._stream.ended and is_complete:
            complete = self._made[-1][1].complete if self._made else block.end - 1
            if second is None or complete < second.decided:
                events.append((complete, self._settle(first, complete, block.epoch)))
        return events

    def _stop(self, first: Contact, second: Contact, epoch: int) -> list[tuple[int, Event]]:
        """Drop estimates from samples after the second contact.

        Return the final estimate, unless it was returned before.
        """
        made = len(self._made)
        self._made = [pair for pair in self._made if _stands(pair[0], second)]
        if self._is_settled and len(self._made) == made:
            return []
        self.reason = "the second finger touched before there was an estimate"
        return [(second.decided, self._settle(first, second.decided, epoch))]

    def finish(self, sample: int, epoch: int, reason: str) -> list[Event]:
        """End the closing before ``sample``. Return its final estimate if that is new.

        If the closing has no estimate, return a :class:`NoEstimate` with ``reason`` instead.
        """
        if self._first is None or self._is_settled:
            return []
        self.reason = reason
        return [self._settle(self._first, sample - 1, epoch)]

    def _settle(self, first: Contact, complete: int, epoch: int) -> Estimate | NoEstimate:
        self._is_settled = True
        if not self._made:
            self.reason = self._failure or self._stream.reason or self.reason
            return NoEstimate(first, self.reason, complete, epoch)
        self.reason = ""
        used, estimate = self._made[-1]
        final = replace(estimate, final=True)
        if self._second is not None:
            offset = (self._second.sample - first.sample) / self._rate
            final = judged(final, offset, real_time=self._real_time)
        self._made[-1] = used, final
        return final


def _stands(last: int, second: Contact) -> bool:
    """Return True if an estimate depends only on samples before the second contact."""
    return last < second.sample
