"""Boundary around code of other packages: plug-ins and classes that a user names.

Foreign code may raise anything, even SystemExit and KeyboardInterrupt. :class:`ForeignCode`
turns these into an InputError that names the code. It cannot catch the end of the process itself
(``os._exit``, a crash of a C library).
"""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterator
from contextlib import suppress
from types import TracebackType

from firstcontact.core._errors import InputError

#: Titles of foreign modules for messages, by the name of the module.
_modules: dict[str, str] = {}


#: Attribute that marks exceptions of this package's signal handlers. A subclass of
#: KeyboardInterrupt would not work: Python exits as interrupted only for that class itself.
_MARK = "_firstcontact_signal"


class ForeignCode:
    """Context manager that converts any exception of foreign code into an InputError.

    Three exceptions pass unchanged: an InputError, an OSError that names a path, and a real Ctrl-C.
    On exit the import path and the working folder are restored.

    Parameters
    ----------
    title
        Name of the code in the ``with`` block, for messages. If empty, an exception is converted
        only if a module registered with :func:`register_foreign` raised it.
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
            raise InputError(f"{title} raised {summarize_error(error)}: fix it or remove it") from (
                error
            )


def mark_as_signal(error: BaseException) -> BaseException:
    """Mark an exception as raised by a signal handler, not by foreign code."""
    setattr(error, _MARK, True)
    return error


def register_foreign(module: str, title: str) -> None:
    """Register a module as foreign code.

    Parameters
    ----------
    module
        Full name. All modules of its package count as the same code.
    title
        Name for messages.
    """
    _modules[module] = title


def culprit(error: BaseException) -> str:
    """Return the title of the foreign code that raised an exception; "" if none did."""
    for link in _chain(error):
        trace, title = link.__traceback__, ""
        while trace is not None:
            title = _title(trace.tb_frame.f_globals.get("__name__") or "") or title
            trace = trace.tb_next
        if title:
            return title
    return ""


def summarize_error(error: BaseException) -> str:
    """Return type and message of an exception in one line, even if its ``str`` fails."""
    message = ""
    with suppress(BaseException):
        message = str(error)
    return " ".join(f"{type(error).__name__}: {message}".split()).removesuffix(":")


def is_interrupt(error: BaseException) -> bool:
    """Return True if a signal caused the exception."""
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
    """Restore the import path and the working folder."""
    added = [place for place in sys.path if place not in path]
    if sys.path[: len(path)] != path:
        sys.path[:] = [*path, *added]
    if folder is not None and _folder() != folder:
        with suppress(OSError):
            os.chdir(folder)
