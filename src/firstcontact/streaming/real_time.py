"""Settings that prepare this process for real time: scheduling, memory and garbage collection."""

from __future__ import annotations

import ctypes
import gc
import logging
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

#: Longest time for which another Python thread may delay the session's thread, s. Python's default
#: of 5 ms is a third of a window.
SWITCH = 1e-4
#: Flag of ``mlockall`` for the memory that a process has now.
MCL_CURRENT = 1

_log = logging.getLogger("firstcontact.streaming")


@contextmanager
def real_time_process(
    *, real_time: bool, notify: Callable[[str], None] = _log.info
) -> Iterator[Callable[[bool], None]]:
    """Prepare this process for real time during a ``with`` block, if ``real_time`` is True.

    Yield a function that pauses the garbage collector (True) or lets it run (False). ``notify``
    gets a line on the permissions that the system granted.
    """
    if not real_time:
        yield lambda is_urgent: None
        return
    interval, collects = sys.getswitchinterval(), gc.isenabled()
    scheduling = _raise_priority()

    def hurry(is_urgent: bool) -> None:
        if collects:
            (gc.disable if is_urgent else gc.enable)()

    sys.setswitchinterval(min(SWITCH, interval))
    gc.collect()
    gc.freeze()
    unlock_memory = _lock_memory()
    words = ["not granted" if x is None else "granted" for x in (scheduling, unlock_memory)]
    notify(f"system: real-time scheduling {words[0]}, locked memory {words[1]}")
    try:
        yield hurry
    finally:
        if unlock_memory is not None:
            unlock_memory()
        if scheduling is not None:
            policy, priority = scheduling
            try:
                os.sched_setscheduler(0, policy, priority)
            except OSError:  # only the superuser may clear the flag
                with suppress(OSError):
                    os.sched_setscheduler(0, policy | os.SCHED_RESET_ON_FORK, priority)
        hurry(False)
        gc.unfreeze()
        sys.setswitchinterval(interval)


def _raise_priority() -> tuple[int, os.sched_param] | None:
    """Raise this thread's priority. Return its earlier scheduling, to restore it.

    Return None if the system refused.
    """
    if sys.platform != "linux":
        return None
    former = os.sched_getscheduler(0), os.sched_getparam(0)
    with suppress(OSError):
        # Threads and processes that this one starts are scheduled as usual.
        os.sched_setscheduler(0, os.SCHED_RR | os.SCHED_RESET_ON_FORK, os.sched_param(1))
        return former
    return None


def _lock_memory() -> Callable[[], object] | None:
    """Lock this process in memory, so that it is never paged out.

    Return a function that unlocks it; None if the system refused.
    """
    with suppress(OSError, AttributeError):  # a system without these functions
        system = ctypes.CDLL(None)
        if system.mlockall(MCL_CURRENT) == 0:
            unlock_memory: Callable[[], object] = system.munlockall
            return unlock_memory
    return None
