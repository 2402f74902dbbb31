"""Boundary around the code of other packages: plug-ins, and classes that a user names.

Foreign code may raise anything, SystemExit and KeyboardInterrupt among it. :class:`ForeignCode`
turns that into an InputError that names the code. What ends the process itself (``os._exit``, a
crash of a C library) is out of reach.
"""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterator
from contextlib import suppress
from types import TracebackType

from firstcontact.core._errors import InputError

#: Names of loaded foreign modules, and what messages call them.
_modules: dict[str, str] = {}


#: Attribute of exceptions that a signal handler of this package raises. No subclass of
#: KeyboardInterrupt would do: Python ends a program as interrupted only for that class itself.
_MARK = "_firstcontact_signal"


class ForeignCode:
    """Context manager that turns whatever foreign code raises into an InputError.

    An InputError passes, and so does an OSError that names a path: its sentence says all. A
    real Ctrl-C passes, too. The import path and the working folder are restored.

    Parameters
    ----------
    title
        Name of the code that runs in the block, for messages. If empty, only exceptions whose
        traceback holds a module that :func:`register_foreign` knows are turned.
    """

    def __init__(self, title: str = "") -> None:
        self._title = title

    def __enter__(self) -> None:
        if self._title:
            self._path = list(sys.path)
            self._folder = _folder()

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._title:
            _restore(self._path, self._folder)
        if error is None or _passes(error):
            return
        title = self._title or culprit(error)
        if title:
            raise InputError(
                f"{title} raised {summarize_error(error)}: mend it or leave it out"
            ) from (error)


def mark_as_signal(error: BaseException) -> BaseException:
    """Mark an exception that a signal handler raises: it is no foreign code's."""
    setattr(error, _MARK, True)
    return error


def register_foreign(module: str, title: str) -> None:
    """Note that a module is foreign.

    Parameters
    ----------
    module
        Full name. All modules of its package count as the same code.
    title
        Name for messages.
    """
    _modules[module] = title


def culprit(error: BaseException) -> str:
    """Return the title of the foreign code that raised an exception, "" if there is none."""
    for link in _chain(error):
        trace, title = link.__traceback__, ""
        while trace is not None:
            title = _title(trace.tb_frame.f_globals.get("__name__") or "") or title
            trace = trace.tb_next
        if title:
            return title
    return ""


def summarize_error(error: BaseException) -> str:
    """Return type and message of an exception in one line, even if it cannot say its message."""
    message = ""
    with suppress(BaseException):
        message = str(error)
    return " ".join(f"{type(error).__name__}: {message}".split()).removesuffix(":")


def is_interrupt(error: BaseException) -> bool:
    """Return True if a signal caused the exception, and not the code that raised it."""
    if any(hasattr(link, _MARK) for link in _chain(error)):
        return True
    # Without a handler of this package, Python itself raises KeyboardInterrupt.
    default = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    return isinstance(error, KeyboardInterrupt) and default


def _passes(error: BaseException) -> bool:
    named = isinstance(error, OSError) and error.filename is not None
    return named or isinstance(error, InputError) or is_interrupt(error)


def _chain(error: BaseException) -> Iterator[BaseException]:
    seen: set[int] = set()
    link: BaseException | None = error
    while link is not None and id(link) not in seen:
        seen.add(id(link))
        yield link
        link = link.__cause__ or link.__context__


def _title(module: str) -> str:
    if module in _modules:
        return _modules[module]
    package = module.partition(".")[0]
    same = (title for name, title in _modules.items() if name.partition(".")[0] == package)
    return next(same, "")


def _folder() -> str | None:
    try:
        return os.getcwd()  # noqa: PTH109
    except OSError:
        return None


def _restore(path: list[str], folder: str | None) -> None:
    """Bring back the import path, and keep what was added to it at its end."""
    added = [place for place in sys.path if place not in path]
    if sys.path[: len(path)] != path:
        sys.path[:] = [*path, *added]
    if folder is not None and _folder() != folder:
        with suppress(OSError):
            os.chdir(folder)
