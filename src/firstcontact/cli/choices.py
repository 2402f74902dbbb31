"""Options whose choices a registry has: its names stand in the help, plug-ins among them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import tyro


def one_of(names: Iterable[str]) -> Any:
    """What annotates an option that takes one of these; others are refused by the registry."""
    return tyro.conf.arg(metavar="{" + ",".join(names) + "}")


def devices(recorded: bool = True, more: str = "") -> Any:
    """What annotates an option that takes a device; ``recorded``: or a recording of one."""
    from firstcontact.device.opening import SOURCES

    kinds = [kind for kind in SOURCES.values() if recorded or not kind.recorded]
    *others, last = (kind.title for kind in kinds)
    said = f"{', '.join(others)}, or {last}."
    return tyro.conf.arg(help=said[0].upper() + said[1:] + more)
