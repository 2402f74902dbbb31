"""The time ledger: where the milliseconds between a contact and its estimate went."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Collection, Mapping
from dataclasses import dataclass

import numpy as np

from firstcontact.streaming._events import Case, Estimated, Event, PinchDone, Running

#: Pinches that the figures are about: the last so many.
KEPT = 10_000


@dataclass(frozen=True, slots=True)
class Entry:
    """Times of one estimate, s.

    The device's clock counts samples; the host's clock begins when the last byte
    of a block had been read.

    Parameters
    ----------
    decide
        Device: from the contact to the sample that decided it.
    window
        Device: from the contact to the sample that completed the window, the
        filter's look-ahead included.
    wait
        Device: how long that sample waited for the rest of its block, and in the source's filter.
    transport
        Host: how much later that block came than the least delayed ones.
    compute
        Host: from having that block to the estimate.
    total
        From the contact until the estimate was available.
    """

    decide: float
    window: float
    wait: float
    transport: float
    compute: float
    total: float


class Ledger:
    """Collects the times of a run.

    Parameters
    ----------
    rate
        Of the samples, Hz.
    delay
        Of the source's own filter, s; it is in each wait already.
    """

    def __init__(self, rate: float, delay: float = 0.0) -> None:
        self.rate = rate
        self.delay = delay
        self.entries: deque[Entry] = deque(maxlen=KEPT)
        #: Estimates of fixed windows so far.
        self.estimates = 0
        #: Pinches so far, each under its one verdict.
        self.cases: Counter[Case | None] = Counter()
        #: Pinches in time because no second contact was heard.
        self.unheard = 0
        self._first: deque[float] = deque(maxlen=KEPT)
        self._answer: deque[float] = deque(maxlen=KEPT)
        self._used: deque[float] = deque(maxlen=KEPT)
        #: Blocks that took longer to work on than their samples last.
        self.overruns = 0
        #: Blocks so far.
        self.blocks = 0
        #: Time spent on them, s.
        self.busy = 0.0

    def worked(self, spent: float, samples: int) -> None:
        """Note that ``samples`` took ``spent`` s to work on."""
        self.blocks += 1
        self.busy += spent
        self.overruns += spent * self.rate > samples

    def add(self, estimate: Estimated) -> None:
        """Note an estimate."""
        contact = estimate.contact
        self.estimates += 1
        self.entries.append(
            Entry(
                (contact.decided - contact.sample) / self.rate,
                (estimate.complete - contact.sample) / self.rate,
                estimate.waited,
                estimate.transport,
                estimate.compute,
                estimate.after(self.rate),
            )
        )

    def tell(self, event: Event) -> None:
        """Note an answer of an any-time model."""
        if isinstance(event, Running):
            self._answer.append(event.compute)

    def close(self, done: PinchDone) -> None:
        """Note how a pinch ended."""
        self.cases[done.case] += 1
        self.unheard += done.case is Case.IN_TIME and done.second is None
        if done.standing is not None:
            self._first.append(done.answers[0].after(self.rate))
            self._used.append(done.standing.duration)

    def summary(self) -> Mapping[str, float]:
        """Figures so far: counts, and p50, p99 and max of each time, s.

        ``first`` is from the contact to the first answer of an any-time model, ``answer`` from
        having a block to its answers, ``signal`` the length of the signal in standing answers.
        ``in_time``, ``too_late``, ``none`` and ``unjudged`` add up to ``pinches``; ``unheard`` are
        those in time because no second contact was heard.
        """
        figures = {
            "estimates": float(self.estimates),
            "pinches": float(self.cases.total()),
            "in_time": float(self.cases[Case.IN_TIME]),
            "too_late": float(self.cases[Case.TOO_LATE]),
            "none": float(self.cases[Case.NONE]),
            "unjudged": float(self.cases[None]),
            "unheard": float(self.unheard),
            "overruns": float(self.overruns),
            "blocks": float(self.blocks),
            "busy": self.busy,
        }
        if self.delay:
            figures["delay"] = self.delay
        if self.entries:
            entries = list(self.entries)
            for name in ("decide", "window", "wait", "transport", "compute", "total"):
                figures |= _spread(name, [getattr(e, name) for e in entries])
        if self._first:
            figures |= _spread("first", self._first)
            figures |= _spread("answer", self._answer)
            figures |= _spread("signal", self._used)
        return figures


def _spread(name: str, values: Collection[float]) -> Mapping[str, float]:
    array = np.array(values)
    p50, p99 = np.percentile(array, [50, 99])
    return {
        f"{name}_p50": float(p50),
        f"{name}_p99": float(p99),
        f"{name}_max": float(array.max()),
    }
