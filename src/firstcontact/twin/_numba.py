"""Compilation by Numba, with a cache on disk. One log line announces it."""

from __future__ import annotations

import logging
from collections.abc import Iterable
from types import FunctionType
from typing import Any

from numba import njit
from numba.core.event import Event, Listener, register

_log = logging.getLogger(__name__)
_PACKAGE = __name__.partition(".")[0]


class _Notice(Listener):  # type: ignore[misc]  # typed or not, Numba may be missing
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
register("numba:compile", _notice)


_OPTIONS: dict[str, Any] = {"nogil": True, "error_model": "numpy"}


def jit(function: FunctionType, inlined: Iterable[FunctionType]) -> Any:
    """Return the function compiled. Numba compiles it at its first call.

    No "fastmath": the bits must not depend on the compiler's choice of formulas.

    Parameters
    ----------
    function
        Function to compile.
    inlined
        Functions that it may call. Inlined functions keep parameters in registers instead of
        copying them into each call.
    """
    names = dict(function.__globals__)
    for helper in inlined:
        if helper.__globals__ is function.__globals__:
            copy = FunctionType(helper.__code__, names)
            names[helper.__name__] = njit(inline="always", error_model="numpy")(copy)
    copy = FunctionType(function.__code__, names)
    try:
        return njit(cache=True, **_OPTIONS)(copy)
    except RuntimeError:  # neither the source's folder nor the home folder is writable
        _notice.cached = False
        return njit(**_OPTIONS)(copy)
