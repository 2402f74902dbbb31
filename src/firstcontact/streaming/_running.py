"""The any-time model in one closing: an answer each millisecond until the second contact."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from firstcontact.core import Block, Contact, InputError, Layout
from firstcontact.models import TouchStream, moments
from firstcontact.streaming._events import Event, Refused, Running, Settled

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from firstcontact.models import InContextModel, Touches


class RunningAnswers:
    """Asks the model as samples of a closing come, and withdraws what must not count.

    Which answers there are, and which of them stands, does not depend on the blocks.

    Parameters
    ----------
    model
        Asked once for all milliseconds that a block completes.
    layout
        Of the samples.
    clock
        Gives the host's time, s.
    delay
        Of the source's own filter, s.
    radius
        Of the thing, m, as told: infinite for a flat one, NaN where it is not told.
    """

    def __init__(
        self,
        model: InContextModel,
        layout: Layout,
        clock: Callable[[], float],
        delay: float = 0.0,
        radius: float = np.nan,
    ) -> None:
        self._model = model
        self._delay = delay
        self._clock = clock
        self._rate = layout.rate
        self._longest = moments(layout.rate)[-1]
        self._stream = TouchStream(layout, radius)
        self._radius = None if np.isnan(radius) else radius
        self._known: NDArray[np.float64] | None = None
        self._first: Contact | None = None
        self._second: Contact | None = None
        self._settled = self._said = False
        #: Answers that count.
        self.answers: list[Running] = []
        #: Answers that were told.
        self.told = 0
        #: Why there is no answer, "" where there is one or may be.
        self.refused = ""

    @property
    def due(self) -> int | None:
        """So many more samples complete the next answer; None where none is to come."""
        return None if self._second is not None else self._stream.due

    def update(
        self, block: Block, contacts: Sequence[Contact], host: float, transport: float = 0.0
    ) -> list[tuple[int, Event]]:
        """Take the next samples.

        Parameters
        ----------
        block
            Samples of the closing.
        contacts
            Those that are known by its end.
        host
            When its last byte had been read, s.
        transport
            How much later that was than for the least delayed blocks, s.

        Returns
        -------
        list of (int, Event)
            What is found, each with the sample that it is known with.
        """
        found: list[tuple[int, Event]] = []
        new = contacts[0] if contacts and self._first is None else None
        self._first = self._first or new
        second = contacts[1] if len(contacts) > 1 and self._second is None else None
        if not self._stream.ended and self._second is None and not self.refused:
            touches = self._stream.update(block, new)
            if touches is not None and self._first is not None:
                found += self._ask(touches, self._first, second, block, host, transport)
            self._refuse(self._stream.refused)
        if second is not None and self._first is not None:
            self._second = second
            found += self._stop(self._first, second, block.epoch)
        if self.refused and self._first is not None and not self._said:
            self._said = True
            found.append((block.end, Refused(self._first, self.refused, block.epoch)))
        return found

    def _ask(
        self,
        touches: Touches,
        first: Contact,
        second: Contact | None,
        block: Block,
        host: float,
        transport: float,
    ) -> list[tuple[int, Event]]:
        """Answers about these moments, but for those that the second contact forbids."""
        known = np.maximum(first.sample + touches.valid - 1, first.decided)
        if second is not None:
            # What smaller blocks would have told, and no more.
            asked = (known < second.decided) | (touches.valid <= second.sample - first.sample)
            touches, known = touches.take(asked), known[asked]
        if not len(touches):
            return []
        try:
            if self._known is None:
                self._known = self._model.rig_features(touches.take(np.zeros(1, np.intp)))
            given = self._model.answers(touches, np.repeat(self._known, len(touches), axis=0))
        except InputError as error:
            self._refuse(str(error))
            return []
        if not (np.isfinite(given.values) & np.isfinite(given.low) & np.isfinite(given.high)).all():
            self._refuse("the model's answer is no finite number")
            return []
        now = self._clock()
        half = self._model.half_widths(given.spreads, touches.valid, self._rate)
        fresh = [
            Running(
                contact=first,
                value=float(given.values[i]),
                low=float(given.low[i]),
                high=float(given.high[i]),
                level=self._model.level,
                half_width=float(half[i]),
                strange=bool(given.strange[i]),
                samples=int(touches.valid[i]),
                radius=self._radius,
                duration=int(touches.valid[i]) / self._rate,
                complete=int(known[i]),
                epoch=block.epoch,
                host=now,
                compute=now - host,
                waited=(block.end - 1 - int(known[i])) / self._rate + self._delay,
                transport=transport,
            )
            for i in range(len(touches))
        ]
        self.answers += fresh
        self.told += len(fresh)
        found: list[tuple[int, Event]] = [(e.complete, e) for e in fresh]
        last = fresh[-1]
        if last.samples == self._longest and (second is None or last.complete < second.decided):
            found.append((last.complete, self._settle(first, last.complete, block.epoch)))
        return found

    def _stop(self, first: Contact, second: Contact, epoch: int) -> list[tuple[int, Event]]:
        """Nothing after the second contact counts; what stands where that was not known yet."""
        allowed = second.sample - first.sample
        self.answers = [e for e in self.answers if e.samples <= allowed]
        if self._settled and self.told == len(self.answers):
            return []
        if not self.answers:
            self._refuse("the second finger touched before there was an answer")
        return [(second.decided, self._settle(first, second.decided, epoch))]

    def finish(self, sample: int, epoch: int, why: str) -> list[Event]:
        """The closing ends before this sample: what stands, where that was not told yet.

        ``why`` it ends is why there is no answer, where there is none and nothing else is known.
        """
        if self._first is None or self._settled:
            return []
        if not self.answers:
            self._refuse(why)
        return [self._settle(self._first, sample - 1, epoch)]

    def _settle(self, first: Contact, complete: int, epoch: int) -> Settled:
        """What stands, nothing where there is no answer that counts."""
        self._settled = True
        answer = self.answers[-1] if self.answers else None
        why = "" if answer is not None else self.refused
        return Settled(first, answer, self.told - len(self.answers), complete, epoch, why)

    def _refuse(self, why: str) -> None:
        self.refused = self.refused or why
