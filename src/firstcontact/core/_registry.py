"""Things of one kind by name: our own, and those that other packages bring as plug-ins."""

from __future__ import annotations

import inspect
import logging
from collections.abc import Iterator, Mapping
from contextlib import AbstractContextManager, nullcontext
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from typing import Any, Generic, Protocol, TypeVar

from firstcontact.core._errors import InputError
from firstcontact.core._foreign import ForeignCode, is_interrupt, register_foreign, summarize_error

_log = logging.getLogger(__name__)


class Named(Protocol):
    """What can be registered."""

    @property
    def name(self) -> str:
        """On the command line, in files and in results."""


E = TypeVar("E", bound=Named)


class Registry(Mapping[str, E], Generic[E]):
    """Entries by name, in the order of figures and tables; each is imported when it is asked for.

    A plug-in is imported when it is looked up by its name; iterating looks up all. One that cannot
    be loaded is named with its reason, on the log and in :attr:`failed`, and is not in the
    registry; it stops nothing else.

    Parameters
    ----------
    kind
        What the entries are, in the singular, for messages: "estimator".
    group
        Of the entry points by which other packages register theirs:
        "firstcontact.estimators". The name of the entry point is the name of the entry.
    own
        Name of each entry of ours, and where it is: "package.module:object".
    default
        Name of the entry that is meant where none is named; the first if None.
    base
        Class that entries of other packages extend: "package.module:Class". A protocol asks for
        its attributes only.
    instances
        Whether entries are instances of the base, and not classes that extend it.
    maker
        Function that makes an entry of a name with a colon, as "package.module:function". None
        if such names are no entries.

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
        own: Mapping[str, str | E],
        default: str | None = None,
        *,
        base: str | None = None,
        instances: bool = False,
        maker: str | None = None,
    ) -> None:
        self.kind = kind
        self.group = group
        #: Name of the entry that is meant where none is named.
        self.default = next(iter(own)) if default is None else default
        #: Why a plug-in is not there, by its name.
        self.failed: dict[str, str] = {}
        self._base, self._instances, self._maker = base, instances, maker
        self._included: list[str] = []
        self._own = dict(own)
        self._loaded: dict[str, E] = {}
        self._plugins: dict[str, EntryPoint] | None = None

    @property
    def own(self) -> tuple[str, ...]:
        """Names of the entries of this package."""
        return tuple(self._own)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all entries; no plug-in is imported for them."""
        return (*self._own, *self._found(), *self._included)

    def __getitem__(self, name: str) -> E:
        if name not in self._loaded:
            if name in self._own:
                self._loaded[name] = self._import(self._own[name])
            elif name not in self._found() or not self._load(name):
                raise KeyError(name)
        return self._loaded[name]

    def __iter__(self) -> Iterator[str]:
        yield from self._own
        for name in list(self._found()):
            if name in self._loaded or self._load(name):
                yield name
        yield from self._included

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def find(self, name: str) -> E:
        """Return the entry of this name; a name with a colon may be that of an object to import.

        Raises
        ------
        InputError
            There is none; says which there are, or why a plug-in is not.
        """
        if ":" in name and self._maker is not None and name not in self._loaded:
            made: E = self._import(self._maker)(name)  # type: ignore[operator]
            self._loaded[name] = made
        try:
            return self[name]
        except KeyError:
            why = self.failed.get(name)
            if why is not None:
                raise InputError(
                    f"{self._title(name)} cannot be loaded ({why}): update or remove its package"
                ) from None
            raise InputError(
                f"no {self.kind} is called {name!r}: choose one of {', '.join(self.names)}"
            ) from None

    def include(self, name: str) -> None:
        """Add the entry of a name with a colon, so that iterating gives it, too.

        Raises
        ------
        InputError
            As :meth:`find`.
        """
        self.find(name)
        if name not in self.names:
            self._included.append(name)

    def calling(self, name: str) -> AbstractContextManager[None]:
        """Return the boundary for a block that calls an entry; only plug-ins have one."""
        return ForeignCode(self._title(name)) if name in self._found() else nullcontext()

    def _title(self, name: str) -> str:
        return f"the plug-in {name!r} ({self.group})"

    def _import(self, where: str | E) -> E:
        if not isinstance(where, str):
            return where
        module, _, attribute = where.partition(":")
        entry: E = getattr(import_module(module), attribute)
        return entry

    def _found(self) -> dict[str, EntryPoint]:
        if self._plugins is None:
            self._plugins = {}
            for point in sorted(entry_points(group=self.group), key=lambda p: p.name):
                if point.name in self._own or point.name in self._plugins:
                    self._fail(point.name, f"there is a {self.kind} of that name already")
                else:
                    self._plugins[point.name] = point
        return self._plugins

    def _load(self, name: str) -> bool:
        """Load a plug-in and return True, or drop it and return False."""
        try:
            with ForeignCode(self._title(name)):
                point = self._found()[name]
                register_foreign(point.module, self._title(name))
                entry: E = point.load()
                self._check(name, entry)
        except BaseException as error:
            if is_interrupt(error):
                raise
            del self._found()[name]
            # An InputError of the boundary only wraps what was raised.
            self._fail(name, summarize_error(error.__cause__ or error))
            return False
        self._loaded[name] = entry
        return True

    def _check(self, name: str, entry: Any) -> None:
        """Refuse an entry of another name, of the wrong kind, or with something missing.

        Raises
        ------
        TypeError
            It is one of these.
        """
        if entry.name != name:
            raise TypeError(f"it calls itself {entry.name!r}")
        if self._base is None:
            return
        base: Any = self._import(self._base)
        protocol = getattr(base, "_is_protocol", False)
        if self._instances:
            fits = isinstance(entry, base)
        else:
            fits = isinstance(entry, type) and (protocol or issubclass(entry, base))
        if not fits:
            what = "an instance" if self._instances else "a class"
            raise TypeError(f"it must be {what} of {self._base.replace(':', '.')}")
        needed = [n for k in base.__mro__ for n, a in inspect.get_annotations(k).items() if _of(a)]
        if protocol:
            needed += [n for n in vars(base) if not n.startswith("_")]
        lacks = {n for n in needed if not hasattr(entry, n)} | getattr(
            entry, "__abstractmethods__", frozenset()
        )
        if lacks:
            raise TypeError(f"it lacks {', '.join(sorted(lacks))}")

    def _fail(self, name: str, why: str) -> None:
        self.failed[name] = why
        _log.warning("plug-in %s (%s) left out: %s", name, self.group, why)


def _of(annotation: object) -> bool:
    """Return True if an annotation, as text, is that of a class attribute."""
    return str(annotation).startswith("ClassVar")
