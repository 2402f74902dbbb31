"""Things of one kind by name: our own, and those that other packages bring as plug-ins."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Mapping
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from typing import Generic, Protocol, TypeVar

from firstcontact.core.errors import InputError

_log = logging.getLogger(__name__)


class Named(Protocol):
    """What can be registered."""

    @property
    def name(self) -> str:
        """On the command line, in files and in results."""


E = TypeVar("E", bound=Named)


class Registry(Mapping[str, E], Generic[E]):
    """Entries by name, in the order of figures and tables; each is imported when it is asked for.

    A plug-in that cannot be loaded is named with its reason, on the log and in
    :attr:`failed`, and is not in the registry; it stops nothing else.

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

    Examples
    --------
    >>> class Colour:
    ...     name = "blue"
    >>> colours = Registry("colour", "example.colours", {"blue": Colour})
    >>> list(colours), colours.find("blue").name
    (['blue'], 'blue')
    """

    def __init__(
        self, kind: str, group: str, own: Mapping[str, str | E], default: str | None = None
    ) -> None:
        self.kind = kind
        self.group = group
        #: Name of the entry that is meant where none is named.
        self.default = next(iter(own)) if default is None else default
        #: Why a plug-in is not there, by its name.
        self.failed: dict[str, str] = {}
        self._own = dict(own)
        self._loaded: dict[str, E] = {}
        self._plugins: dict[str, EntryPoint] | None = None

    def __getitem__(self, name: str) -> E:
        if name not in self._loaded:
            if name in self._own:
                self._loaded[name] = self._import(name)
            elif name not in self._found() or not self._load(name):
                raise KeyError(name)
        return self._loaded[name]

    def __iter__(self) -> Iterator[str]:
        yield from self._own
        for name in list(self._found()):
            if self._load(name):
                yield name

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def find(self, name: str) -> E:
        """The entry of this name.

        Raises
        ------
        InputError
            There is none; says which there are, or why a plug-in is not.
        """
        try:
            return self[name]
        except KeyError:
            why = self.failed.get(name)
            if why is not None:
                raise InputError(
                    f"the plug-in {name!r} ({self.group}) cannot be loaded ({why}): update or "
                    "remove its package"
                ) from None
            raise InputError(
                f"no {self.kind} is called {name!r}: choose one of {', '.join(self)}"
            ) from None

    def _import(self, name: str) -> E:
        where = self._own[name]
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
        """Whether a plug-in is there; it is dropped where it cannot be loaded."""
        if name in self._loaded:
            return True
        try:
            entry: E = self._found()[name].load()
            if entry.name != name:
                raise ValueError(f"it calls itself {entry.name!r}")
        except Exception as error:  # a stranger's code: whatever it is, it stops nothing else
            del self._found()[name]
            self._fail(name, f"{type(error).__name__}: {error}")
            return False
        self._loaded[name] = entry
        return True

    def _fail(self, name: str, why: str) -> None:
        self.failed[name] = why
        _log.warning("plug-in %s (%s) left out: %s", name, self.group, why)
