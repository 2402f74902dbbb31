"""Compilation of the twin's functions, with a cache on disk. One log line announces it."""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import Any, TypeVar

from numba import njit
from numba.core.event import Event, Listener, register

F = TypeVar("F", bound=Callable[..., Any])

_log = logging.getLogger(__name__)
_PACKAGE = __name__.partition(".")[0]


class _Notice(Listener):
    """Listener that logs one line when this process compiles a function for the first time."""

    _given = False
    #: True if compiled functions are stored for other processes.
    cached = True

    def on_start(self, event: Event) -> None:
        """Log the line unless the compiled function belongs to Numba or another package."""
        module = event.data["dispatcher"].py_func.__module__
        if self._given or module.partition(".")[0] != _PACKAGE:
            return
        self._given = True
        often = (
            "once on this machine"
            if self.cached
            else "in each process, because no cache folder can be written: set NUMBA_CACHE_DIR"
        )
        _log.warning("compiling the simulated hand (some 8 s, %s)", often)

    def on_end(self, event: Event) -> None:
        """Ignore the end of a compilation."""


_notice = _Notice()
register("numba:compile", _notice)  # type: ignore[no-untyped-call]


def compiled(**options: Any) -> Callable[[F], F]:
    """Return a decorator that compiles a function at its first call, to run without the GIL.

    Parameters
    ----------
    **options
        Options of ``numba.njit``.
    """

    def decorate(function: F) -> F:
        try:
            dispatcher: F = njit(cache=True, nogil=True, **options)(function)
        except RuntimeError:  # neither the source's folder nor the home folder is writable
            _notice.cached = False
            dispatcher = njit(nogil=True, **options)(function)
        return dispatcher

    return decorate
