"""Heavy parts are extras: say which one is missing."""

from __future__ import annotations

from collections.abc import Iterable
from importlib.util import find_spec
from typing import Protocol

from firstcontact.core.errors import InputError


class Needing(Protocol):
    """A registered entry that may need more than the base install."""

    @property
    def extra(self) -> str:
        """Of this package; "" where the base install does."""

    @property
    def modules(self) -> tuple[str, ...]:
        """What the extra brings and the entry imports."""


def absent(modules: Iterable[str]) -> list[str]:
    """Those of these modules that are not installed."""
    return [m for m in modules if find_spec(m) is None]


def need(extra: str, *modules: str) -> None:
    """Refuse with the install command if any of these modules is missing.

    Raises
    ------
    InputError
        Names the extra to install.
    """
    missing = absent(modules)
    if missing:
        raise InputError(
            f"this needs {', '.join(missing)}, which the base install leaves out: "
            f"pip install 'firstcontact[{extra}]'"
        )


def need_for(entry: Needing) -> None:
    """Refuse with the install command if what a registered entry needs is missing.

    Raises
    ------
    InputError
        Names the extra to install.
    """
    need(entry.extra, *entry.modules)
