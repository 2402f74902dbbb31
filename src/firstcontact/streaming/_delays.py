"""Reasons why estimates come too late: this computer, another output, or the device."""

from __future__ import annotations

import math
import os
from contextlib import suppress
from pathlib import Path

from firstcontact.core import Estimate

#: The Linux kernel's times of the calling thread, ns: running, and ready but without a processor.
_TIMES = Path("/proc/thread-self/schedstat")


def processor_wait() -> float:
    """Return how long this thread was ready, but without a processor, s; NaN if unknown."""
    with suppress(OSError, ValueError, IndexError):
        return 1e-9 * int(_TIMES.read_bytes().split()[1])
    return math.nan


def delay_cause(first: Estimate, offset: float | None, queued: float, stalled: float) -> str:
    """Return the reason why the first estimate came too late, or "" if a delay was not the reason.

    ``offset`` is the time from the first to the second contact, ``queued`` the wait for a
    processor, and ``stalled`` the time in which the thread did not run for any reason, s.
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
