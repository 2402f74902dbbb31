"""Options whose choices a registry has: its names stand in the help, plug-ins among them."""

from __future__ import annotations

from typing import Any

import tyro

from firstcontact.core.registry import Registry


def one_of(registry: Registry[Any]) -> Any:
    """What annotates an option that takes a name out of a registry."""
    return tyro.conf.arg(metavar="{" + ",".join(registry) + "}")
