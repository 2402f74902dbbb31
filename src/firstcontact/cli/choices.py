"""Options whose choices a registry has: its names stand in the help, plug-ins among them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import tyro

from firstcontact.core import Registry


def one_of(names: Iterable[str] | Registry[Any]) -> Any:
    """What annotates an option that takes one of these; others are refused by the registry."""
    # Iterating a registry would import every plug-in.
    listed = names.names if isinstance(names, Registry) else names
    return tyro.conf.arg(metavar="{" + ",".join(listed) + "}")


def devices(recorded: bool = True, more: str = "") -> Any:
    """What annotates an option that takes a device; ``recorded``: or a recording of one."""
    from firstcontact.device import SOURCES

    kinds = [SOURCES[name] for name in SOURCES.own]
    titles = [kind.title for kind in kinds if recorded or not kind.recorded]
    # What a plug-in says of itself is in its module, which is not imported for help.
    titles += [f"{name}:... of a plug-in" for name in SOURCES.names if name not in SOURCES.own]
    *others, last = titles
    said = f"{', '.join(others)}, or {last}."
    return tyro.conf.arg(help=said[0].upper() + said[1:] + more)
