"""Options whose choices come from a registry: the help lists its names, plug-ins included."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import tyro

from firstcontact.core import Registry


def one_of(names: Iterable[str] | Registry[Any]) -> Any:
    """Return the annotation of an option that takes one of these names."""
    # Iterating a registry would import every plug-in.
    listed = names.names if isinstance(names, Registry) else names
    return tyro.conf.arg(metavar="{" + ",".join(listed) + "}")


def devices(recorded: bool = True, more: str = "") -> Any:
    """Return the annotation of an option that takes a device, or a recording if ``recorded``."""
    from firstcontact.device import SOURCES

    kinds = [SOURCES[name] for name in SOURCES.own]
    titles = [kind.title for kind in kinds if recorded or not kind.recorded]
    # The title of a plug-in is in its module, which is not imported for help.
    titles += [f"{name}:... of a plug-in" for name in SOURCES.names if name not in SOURCES.own]
    *first, last = titles
    text = f"{', '.join(first)}, or {last}."
    return tyro.conf.arg(help=text[0].upper() + text[1:] + more)
