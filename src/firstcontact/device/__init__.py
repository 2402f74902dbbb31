"""Devices: the wire protocol, and sources of samples behind one interface."""

from __future__ import annotations

from typing import TYPE_CHECKING

from firstcontact.core.lazy import lazily

if TYPE_CHECKING:
    from firstcontact.device.opening import SOURCES, SourceKind, open_source
    from firstcontact.device.source import Arrival, Descriptor, Health, Source
else:
    __getattr__ = lazily(
        __name__,
        {
            "opening": "SOURCES SourceKind open_source",
            "source": "Arrival Descriptor Health Source",
        },
    )

__all__ = [
    "SOURCES",
    "Arrival",
    "Descriptor",
    "Health",
    "Source",
    "SourceKind",
    "open_source",
]
