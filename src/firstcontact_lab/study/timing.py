"""Inference time of one window, compared with the training library."""

from __future__ import annotations

import os
import resource
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Record
from firstcontact.models import Reference, WindowModel, Windows

#: Number of calls before the measurement, which fill caches.
WARM_UP = 200
#: Divisor of the number of calls to the slow reference: a tenth of them is enough for percentiles.
REFERENCE_SHARE = 10

Call = Callable[[Any], object]


#: Preemptions are counted for this thread alone if the system supports it.
_WHOSE = getattr(resource, "RUSAGE_THREAD", resource.RUSAGE_SELF)


@dataclass(frozen=True, slots=True, eq=False)
class Timed:
    """Times of single calls. Arrays have the shape (calls,)."""

    microseconds: NDArray[np.float64]
    preempted: NDArray[np.bool_]

    @property
    def uninterrupted(self) -> NDArray[np.float64]:
        """Times of the calls that were not preempted; if all were preempted, of all calls."""
        return self.microseconds if self.preempted.all() else self.microseconds[~self.preempted]


def timed(call: Call, windows: Sequence[Any] | NDArray[Any], calls: int) -> Timed:
    """Return the times of ``calls`` single calls over the windows in turn, after a warm-up."""
    for i in range(min(WARM_UP, calls)):
        call(windows[i % len(windows)])
    spent = np.empty(calls)
    preempted = np.zeros(calls, dtype=np.bool_)
    switches = preemptions()
    for i in range(calls):
        window = windows[i % len(windows)]
        began = time.perf_counter_ns()
        call(window)
        spent[i] = time.perf_counter_ns() - began
        switches_before, switches = switches, preemptions()
        preempted[i] = switches > switches_before
    return Timed(spent / 1e3, preempted)


def preemptions() -> int:
    """Return how often other processes have preempted this thread so far."""
    return resource.getrusage(_WHOSE).ru_nivcsw


def load() -> float:
    """Return the mean number of runnable processes in the last minute."""
    return os.getloadavg()[0]


class InferenceTime(Record, frozen=True, kw_only=True):
    """Time to predict one window on one thread, µs."""

    p50: float
    p99: float
    p99_with_preempted: float
    calls: int
    preempted: int
    load: float
    cores: int
    reference: str | None = None
    reference_p50: float | None = None
    reference_p99: float | None = None
    reference_calls: int | None = None
    speedup: float | None = None
    support_vectors: int | None = None


def time_inference(
    model: WindowModel, X: Windows, reference: Reference | None, calls: int
) -> InferenceTime:
    """Return the time to predict one window on one thread, by the model and another library."""
    import threadpoolctl

    times = msgspec.structs.replace(
        time_calls(model.predict_one, X, calls), support_vectors=model.notes.get("support_vectors")
    )
    if reference is None:
        return times
    with threadpoolctl.threadpool_limits(1):
        theirs = timed(reference.call, reference.inputs, max(1, calls // REFERENCE_SHARE))
    return msgspec.structs.replace(
        times,
        reference=reference.name,
        reference_p50=float(np.percentile(theirs.uninterrupted, 50)),
        reference_p99=float(np.percentile(theirs.uninterrupted, 99)),
        reference_calls=len(theirs.microseconds),
        speedup=float(np.percentile(theirs.uninterrupted, 50)) / times.p50,
    )


def time_calls(call: Call, inputs: Sequence[Any] | NDArray[Any], calls: int) -> InferenceTime:
    """Return the time of single calls on one thread, over the inputs in turn."""
    import threadpoolctl

    busy = load()
    with threadpoolctl.threadpool_limits(1):
        times = timed(call, inputs, calls)
    return InferenceTime(
        p50=float(np.percentile(times.uninterrupted, 50)),
        p99=float(np.percentile(times.uninterrupted, 99)),
        p99_with_preempted=float(np.percentile(times.microseconds, 99)),
        calls=calls,
        preempted=int(times.preempted.sum()),
        load=busy,
        cores=os.cpu_count() or 1,
    )
