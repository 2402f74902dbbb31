"""Registries of named entries: built-in entries, and plug-ins of other packages."""

from __future__ import annotations

import logging
import threading
from collections.abc import Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager, nullcontext
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from typing import Any, Generic, Protocol, TypeVar

from firstcontact.core._errors import ArgumentError, InputError
from firstcontact.core.text import summarize_error

_log = logging.getLogger("firstcontact.core")


@contextmanager
def foreign_errors(code: str) -> Iterator[None]:
    """Convert exceptions of a plug-in's or user's code to InputError: "``code`` raised ...".

    InputError, and errors about a file, pass unchanged.
    """
    try:
        yield
    except Exception as error:
        if isinstance(error, InputError) or getattr(error, "filename", None) is not None:
            raise
        raise InputError(f"{code} raised {summarize_error(error)}") from error


class Named(Protocol):
    """Object that a registry can contain."""

    @property
    def name(self) -> str:
        """Name of the object on the command line, in files and in results."""


E = TypeVar("E", bound=Named)


class Registry(Mapping[str, E], Generic[E]):
    """Mapping from names to entries, such as detectors: built-in ones, and those of plug-ins.

    An entry is imported on first use: looking up a name imports one plug-in, and iterating imports
    all. A plug-in that fails to load is left out. The log and :attr:`failed` state its name and the
    reason. Built-in entries come first, then plug-ins by name.

    Parameters
    ----------
    kind
        Noun for one entry in messages, such as "estimator".
    group
        Group of Python entry points through which other packages add entries, such as
        "firstcontact.estimators". The name of an entry point is the name of its entry.
    built_in
        Built-in entries by name: the object, or its location as "package.module:object".
    default
        Name of the default entry; None means the first.
    base
        Location of the base class that plug-ins must use, as "package.module:Class".
    instances
        True if plug-ins must be instances of ``base``, False if they must be subclasses.
    maker
        Function that makes an entry from a name with a colon; given as "package.module:function".
        None means that such names are refused.

    Examples
    --------
    >>> class Colour:
    ...     name = "blue"
    >>> colours = Registry("colour", "example.colours", {"blue": Colour})
    >>> list(colours), colours.find("blue").name
    (['blue'], 'blue')
    """

    def __init__(
        self,
        kind: str,
        group: str,
        built_in: Mapping[str, str | E],
        default: str | None = None,
        *,
        base: str | None = None,
        instances: bool = False,
        maker: str | None = None,
    ) -> None:
        self.kind = kind
        self.group = group
        #: Name of the default entry.
        self.default = next(iter(built_in)) if default is None else default
        #: Reason for each plug-in that failed to load, by the plug-in's name.
        self.failed: dict[str, str] = {}
        self._base, self._instances, self._maker = base, instances, maker
        self._included: list[str] = []
        self._own = dict(built_in)
        self._loaded: dict[str, E] = {}
        self._plugins: dict[str, EntryPoint] | None = None
        self._lock = threading.RLock()  # the import of a plug-in may look up another one

    @property
    def builtin_names(self) -> tuple[str, ...]:
        """Names of the built-in entries."""
        return tuple(self._own)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all entries. Reading this property imports no plug-in."""
        return (*self._own, *self._find_plugins(), *self._included)

    def __getitem__(self, name: str) -> E:
        if name not in self._loaded:
            if name in self._own:
                self._loaded[name] = self._import(self._own[name])
            elif not self._load(name):
                raise KeyError(name)
        return self._loaded[name]

    def __iter__(self) -> Iterator[str]:
        yield from self._own
        for name in list(self._find_plugins()):
            if self._load(name):
                yield name
        yield from self._included

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def find(self, name: str) -> E:
        """Return the entry called ``name``, such as the detector "cusum". Import it if needed.

        If the registry has a ``maker``, a name with a colon (``PACKAGE:NAME``) makes a new entry.

        Raises
        ------
        InputError
            No entry has this name, or its plug-in failed to load. The message lists the names, or
            says why the plug-in failed.
        """
        if ":" in name and self._maker is not None and name not in self._loaded:
            made: E = self._import(self._maker)(name)  # type: ignore[operator]
            self._loaded[name] = made
        try:
            return self[name]
        except KeyError:
            reason = self.failed.get(name)
            if reason is not None:
                raise ArgumentError(
                    f"{self._title(name)} cannot be loaded ({reason}): update or remove its package"
                ) from None
            raise ArgumentError(
                f"no {self.kind} is called {name!r}: choose one of {', '.join(self.names)}"
            ) from None

    def include(self, name: str) -> None:
        """Add an entry called ``PACKAGE:NAME``, so that iterating over the registry yields it."""
        self.find(name)
        if name not in self.names:
            self._included.append(name)

    def reload(self) -> None:
        """Forget loaded and included entries, and find plug-ins that were installed meanwhile."""
        with self._lock:
            self._plugins = None
            for entries in (self._loaded, self._included, self.failed):
                entries.clear()

    def convert_errors(self, name: str) -> AbstractContextManager[None]:
        """Return a context manager for calls of the methods of the entry called ``name``.

        If the entry is a plug-in, exceptions in the body become an InputError that names it.
        """
        return foreign_errors(self._title(name)) if name in self._find_plugins() else nullcontext()

    def _title(self, name: str) -> str:
        return f"the plug-in {name!r} ({self.group})"

    def _import(self, location: str | E) -> E:
        if not isinstance(location, str):
            return location
        module, _, attribute = location.partition(":")
        entry: E = getattr(import_module(module), attribute)
        return entry

    def _find_plugins(self) -> dict[str, EntryPoint]:
        with self._lock:
            if self._plugins is None:
                self._plugins = {}
                for point in sorted(entry_points(group=self.group), key=lambda p: p.name):
                    if point.name in self._own or point.name in self._plugins:
                        self._fail(point.name, f"another {self.kind} has that name")
                    else:
                        self._plugins[point.name] = point
            return self._plugins

    def _load(self, name: str) -> bool:
        """Load a plug-in. Return True if this succeeds. If it fails, drop the plug-in."""
        with self._lock:
            if name in self._loaded or name not in self._find_plugins():
                return name in self._loaded
            try:
                entry: E = self._find_plugins()[name].load()
                self._check(name, entry)
            except Exception as error:
                del self._find_plugins()[name]
                self._fail(name, summarize_error(error))
                return False
            self._loaded[name] = entry
            return True

    def _check(self, name: str, entry: Any) -> None:
        """Raise TypeError if a plug-in's object has a wrong name or type, or lacks a method."""
        if entry.name != name:
            raise TypeError(f"its attribute 'name' is {entry.name!r}, not {name!r}")
        if self._base is None:
            return
        base: Any = self._import(self._base)
        if self._instances:
            is_valid, required = isinstance(entry, base), "an instance"
        else:
            is_valid, required = isinstance(entry, type) and issubclass(entry, base), "a class"
        if not is_valid:
            raise TypeError(f"it must be {required} of {self._base.replace(':', '.')}")
        if missing := getattr(entry, "__abstractmethods__", None):
            raise TypeError(f"it lacks the methods {', '.join(sorted(missing))}")

    def _fail(self, name: str, reason: str) -> None:
        self.failed[name] = reason
        _log.warning("plug-in %s (%s) left out: %s", name, self.group, reason)
