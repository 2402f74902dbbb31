"""Settings of the process that keep live estimates fast."""

from __future__ import annotations

import gc
import os
import sys
from contextlib import suppress
from typing import Self

#: Longest time for which another Python thread may delay the session's thread, s. Python's default
#: of 5 ms is a third of a window.
SWITCH = 1e-4


class Readiness:
    """Context manager with settings of the process for a real-time session."""

    def __init__(self, *, real_time: bool) -> None:
        self._is_active = real_time
        self._collects = False
        self._interval = 0.0
        self._scheduling: tuple[int, int] | None = None  # policy and priority

    def __enter__(self) -> Self:
        if self._is_active:
            self._interval = sys.getswitchinterval()
            sys.setswitchinterval(min(SWITCH, self._interval))
            self._collects = gc.isenabled()
            gc.collect()
            gc.freeze()
            self._raise_priority()
        return self

    def __exit__(self, *exception: object) -> None:
        if self._is_active:
            if self._scheduling is not None:
                policy, priority = self._scheduling
                parameters = os.sched_param(priority)
                try:
                    os.sched_setscheduler(0, policy, parameters)
                except OSError:  # only the superuser may clear the flag
                    with suppress(OSError):
                        os.sched_setscheduler(0, policy | os.SCHED_RESET_ON_FORK, parameters)
            self.hurry(is_urgent=False)
            gc.unfreeze()
            sys.setswitchinterval(self._interval)

    def hurry(self, *, is_urgent: bool) -> None:
        """Disable the garbage collector if estimates are due (``is_urgent``), else enable it."""
        if not self._is_active or not self._collects:
            return
        if is_urgent:
            gc.disable()
        else:
            gc.enable()

    def _raise_priority(self) -> None:
        if sys.platform != "linux":
            return
        scheduling = os.sched_getscheduler(0), os.sched_getparam(0).sched_priority
        # Threads and processes that this one starts are scheduled as usual.
        policy = os.SCHED_RR | os.SCHED_RESET_ON_FORK
        with suppress(OSError):
            os.sched_setscheduler(0, policy, os.sched_param(1))
            self._scheduling = scheduling
