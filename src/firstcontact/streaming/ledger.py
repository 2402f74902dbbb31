"""Statistics of the times between contacts and their estimates, and text about them."""

from __future__ import annotations

import math
import os
from collections import Counter, deque
from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path

import numpy as np

from firstcontact.core import Estimate
from firstcontact.core.text import percent
from firstcontact.streaming.events import PinchDone, Verdict

#: The Linux kernel's times of the calling thread, ns: running, and ready but without a processor.
_TIMES = Path("/proc/thread-self/schedstat")
#: Number of pinches that the statistics cover, the newest ones.
KEPT = 10_000
#: Number of closings without any contact that cannot all be false.
DOUBTFUL = 3
#: Times in the ledger, in the order in which they happen, and their names for people.
TIMES = {
    "decide": "from a contact until it was noticed (device clock)",
    "first": "from a contact until the first estimate was available",
    "signal": "length of the signal in the final estimate",
    "wait": "wait of its last sample for the end of the block (device clock)",
    "transport": "delay of this block beyond the least (this computer's clock)",
    "compute": "computing the estimate (this computer's clock)",
    "total": "from a contact until the final estimate was available",
}


class Ledger:
    """Collector of the delays and counts of a live session.

    Computing times are stored for each estimate, all other times for each pinch.
    """

    def __init__(self, rate: float, delay: float = 0.0) -> None:
        self.rate = rate
        self.delay = delay
        self.blocks = self.estimates = self.closings = 0
        #: Number of pinches so far by verdict.
        self.verdicts: Counter[Verdict | None] = Counter()
        #: Number of pinches in time because no second contact was detected.
        self.unheard = 0
        #: Number of pinches in which the hand used an estimate in time; None without a hand.
        self.used: int | None = None
        #: Number of blocks that took longer to process than their samples last.
        self.overruns = 0
        #: Time spent on the blocks, s.
        self.busy = 0.0
        self._times: dict[str, deque[float]] = {name: deque(maxlen=KEPT) for name in TIMES}

    def worked(self, spent: float, samples: int) -> None:
        """Add the time ``spent`` (s) on a block of this number of samples."""
        self.blocks += 1
        self.busy += spent
        self.overruns += spent * self.rate > samples

    def add(self, estimate: Estimate) -> None:
        self.estimates += 1
        self._times["compute"].append(estimate.compute)

    def count_use(self, *, is_used: bool) -> None:
        """Count one more pinch, in which the hand used an estimate in time or not."""
        self.used = (self.used or 0) + is_used

    def close(self, pinch: PinchDone) -> None:
        self.verdicts[pinch.verdict] += 1
        self.unheard += pinch.verdict is Verdict.IN_TIME and pinch.second is None
        final = pinch.final
        if final is None:
            return
        contact = final.contact
        times = {
            "decide": (contact.decided - contact.sample) / self.rate,
            "first": pinch.estimates[0].available,
            "signal": final.elapsed,
            "wait": final.waited,
            "transport": final.transport,
            "total": final.available,
        }
        for name, seconds in times.items():
            self._times[name].append(seconds)

    def summary(self) -> Mapping[str, float]:
        """Return all counts by name, and the median, 99 % quantile and maximum of each time, s."""
        figures = {
            "estimates": float(self.estimates),
            "pinches": float(self.verdicts.total()),
            **{verdict.value: float(self.verdicts[verdict]) for verdict in Verdict},
            "unjudged": float(self.verdicts[None]),
            "unheard": float(self.unheard),
            "overruns": float(self.overruns),
            "blocks": float(self.blocks),
            "closings": float(self.closings),
            "busy": self.busy,
        }
        if self.used is not None:
            figures["hand_used"] = float(self.used)
        if self.delay:
            figures["delay"] = self.delay
        for name, times in self._times.items():
            if times:
                places = np.array((0.5, 0.99, 1.0)) * (len(times) - 1)
                p50, p99, longest = np.interp(places, np.arange(len(times)), sorted(times)).tolist()
                figures |= {f"{name}_p50": p50, f"{name}_p99": p99, f"{name}_max": longest}
        return figures


def ledger_lines(
    figures: Mapping[str, float],
    *,
    alone: bool = False,
    speed: float = 1.0,
) -> Iterator[str]:
    """Yield lines of text about the number of estimates in a session, and if they were in time.

    ``figures`` come from :meth:`Ledger.summary`. ``alone`` is True if the hand has one sensor only,
    and ``speed`` is the playback speed.
    """
    with_estimate = figures["pinches"] - figures["none"]
    if speed != 1.0:
        yield (
            f"times and verdicts are left out: at --speed {speed:g} they say nothing about a hand "
            "in real time"
        )
    if not figures["pinches"] and figures["closings"] >= DOUBTFUL:
        yield (
            f"{figures['closings']:.0f} closings and no contact: check that the columns are those "
            "of the sensors (not a clock, and not one signal twice), their unit, and that the "
            "sensors touch the object; `firstcontact check` tests them"
        )
    if alone or speed != 1.0:
        yield f"{with_estimate:.0f} of {figures['pinches']:.0f} pinches had an estimate"
    else:
        yield from _verdict_lines(figures)


def detail_lines(
    figures: Mapping[str, float], samples: float, cpu: float, *, speed: float = 1.0
) -> Iterator[str]:
    """Yield lines of text about the delays and the computing time of a session.

    ``figures`` come from :meth:`Ledger.summary`. ``samples`` is the duration of the samples, and
    ``cpu`` the processor time, both s.
    """
    if speed == 1.0:
        yield from _time_lines(figures)
    yield (
        f"{samples:.1f} s of samples in {figures['blocks']:.0f} blocks; "
        f"{figures['overruns']:.0f} of them took longer to process than they last"
    )
    if samples > 0:
        yield f"processor time {percent(cpu / samples)} of one core"
    yield (
        "in force: the last estimate that was available before the second contact, with waiting, "
        "transport and computing"
    )


def _time_lines(figures: Mapping[str, float]) -> Iterator[str]:
    lines = {name: words for name, words in TIMES.items() if f"{name}_p50" in figures}
    if lines:
        yield f"{'times in ms':>64} {'median':>8} {'99 %':>8} {'longest':>8}"
        for name, words in lines.items():
            values = (1e3 * figures[f"{name}_{key}"] for key in ("p50", "p99", "max"))
            yield f"{words:>64} " + " ".join(f"{v:8.3f}" for v in values)
    if "delay" in figures:
        yield f"{1e3 * figures['delay']:.3f} ms of each wait are the source's own filter"


def _verdict_lines(figures: Mapping[str, float]) -> Iterator[str]:
    share = f" ({percent(figures['in_time'] / figures['pinches'])})" if figures["pinches"] else ""
    yield (
        f"estimate in force when the second finger touched: {figures['in_time']:.0f} of "
        f"{figures['pinches']:.0f} pinches{share}; {figures['too_late']:.0f} too late, "
        f"{figures['none']:.0f} without an estimate"
    )
    if "hand_used" in figures:
        used = figures["hand_used"]
        share = f" ({percent(used / figures['pinches'])})" if figures["pinches"] else ""
        yield f"the hand used it: {used:.0f} of {figures['pinches']:.0f} pinches{share}"
    if unheard := figures["unheard"]:
        yield f"in {unheard:.0f} of these pinches no second contact was detected"


def processor_wait() -> float:
    """Return the time for which this thread was ready, but had no processor, s; NaN if unknown."""
    with suppress(OSError, ValueError, IndexError):
        return 1e-9 * int(_TIMES.read_bytes().split()[1])
    return math.nan


def delay_cause(first: Estimate, offset: float | None, queued: float, stalled: float) -> str:
    """Return a sentence on why the first estimate came too late; "" if no delay was the reason.

    ``offset`` is the time from the first to the second contact, ``queued`` the wait for a
    processor, and ``stalled`` the time in which the thread did not run for any reason, all s.
    """
    delay = first.waited + first.transport + first.compute
    if offset is None or not first.available - delay < offset <= first.available:
        return ""
    here = max(stalled, 0.0 if math.isnan(queued) else queued)
    load, processors = os.getloadavg()[0] if hasattr(os, "getloadavg") else 0.0, os.cpu_count() or 1
    if queued >= 0.5 * here or load > processors:
        held = "this computer is busy: the program could not run for {:.1f} ms"
    elif math.isnan(queued):
        held = "the program could not run for {:.1f} ms; this system does not report why"
    else:
        held = "the page, a recording or another output held the program up for {:.1f} ms"
    causes = (
        (here, held),
        (first.compute - here, "computing the estimate took {:.1f} ms on this computer"),
        (first.transport - here, "the device delivered its samples {:.1f} ms late"),
        (first.waited, "the device sends such long blocks that samples waited {:.1f} ms"),
    )
    seconds, sentence = max(causes)
    # A simulated device is late on a busy computer, too.
    crowd = f" (this computer: load {load:.1f}, {processors} processors)"
    return sentence.format(1e3 * seconds) + (crowd if load > processors else "")
