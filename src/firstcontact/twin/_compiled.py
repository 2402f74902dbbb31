"""Choice of the code that runs the twin's loops: the compiled kernels, else Numba."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, wraps
from typing import Any, TypeVar, cast

from firstcontact.core import kernels, require_twin

F = TypeVar("F", bound=Callable[..., Any])

_inlined: list[Any] = []


def compiled(function: F) -> F:
    """Decorate a loop over numbers and arrays. The Python code is the reference of its kernel.

    Each call runs the kernel of the same name, if the kernels were built. Otherwise Numba compiles
    the function at its first call. Both give the same bits as the Python code, and run without the
    GIL.

    Parameters
    ----------
    function
        Function with positional arguments: numbers, contiguous arrays, and named tuples of numbers.
    """
    name = function.__name__.lstrip("_")

    @wraps(function)
    def call(*arguments: Any) -> Any:
        module = kernels()
        if module is not None:
            return getattr(module, name)(*arguments)
        return _by_numba(function)(*arguments)

    return cast(F, call)


def inlined(function: F) -> F:
    """Decorate a function that functions with :func:`compiled` call."""
    _inlined.append(function)
    return function


@cache
def _by_numba(function: Any) -> Any:
    require_twin()
    from firstcontact.twin._numba import jit

    return jit(function, _inlined)
