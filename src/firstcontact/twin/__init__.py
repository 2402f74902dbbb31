"""The pinch twin: a physical model that makes recordings."""

from __future__ import annotations

from typing import TYPE_CHECKING

from firstcontact.core.lazy import lazily

if TYPE_CHECKING:
    from firstcontact.twin.conditions import CONDITIONS
    from firstcontact.twin.stream import TwinStream
else:
    __getattr__ = lazily(
        __name__,
        {
            "conditions": "CONDITIONS",
            "stream": "TwinStream",
        },
    )

__all__ = [
    "CONDITIONS",
    "TwinStream",
]
