"""Packages whose names are imported when they are asked for: the help of a command needs none."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module


def lazily(package: str, modules: Mapping[str, str]) -> Callable[[str], object]:
    """A ``__getattr__`` for a package, as PEP 562 has it.

    Parameters
    ----------
    package
        Its ``__name__``.
    modules
        The public names of each module of the package, with spaces between.
    """
    names = {name: module for module, told in modules.items() for name in told.split()}

    def get(name: str) -> object:
        if name not in names:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        return getattr(import_module(f"{package}.{names[name]}"), name)

    return get
