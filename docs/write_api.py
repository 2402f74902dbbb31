"""Write docs/reference/python.md: what the rooms of the package offer to others.

python docs/write_api.py
"""

from __future__ import annotations

import re
from importlib import import_module
from pathlib import Path
from typing import Any

from firstcontact.core import Registry

PAGE = Path(__file__).parent / "reference" / "python.md"
ROOMS = (
    "core", "recording", "signal", "contact", "models", "twin", "grasp", "device", "streaming",
    "collect", "export", "testing",
)  # fmt: skip
HEAD = """\
# From Python

Written by `docs/write_api.py` out of the docstrings; a test holds this page against them.

What stands here is meant for others: `from firstcontact.contact import detect`. Semantic versioning
promises it: what is taken away or changes its meaning raises the first number of the version (the
second before 1.0). Everything else is the package's own affair and may change at any time.
[Architecture](../explanation/architecture.md) says how the rooms fit, `help(...)` the rest of each.
"""


def said(thing: Any) -> str:
    """The first sentence that something says of itself."""
    if isinstance(thing, Registry):
        return f"All {thing.kind}s by name, those of plug-ins among them."
    if isinstance(thing, dict):
        return f"By name: {', '.join(f'`{name}`' for name in thing)}."
    first = " ".join((thing.__doc__ or "").strip().split("\n\n")[0].split())
    return re.sub(r":\w+:(?=`)", "", first).replace("``", "`")


def room(name: str) -> str:
    """A table of a room."""
    module = import_module(f"firstcontact.{name}")
    rows = [f"| `{word}` | {said(getattr(module, word))} |" for word in sorted(module.__all__)]
    head = f"## firstcontact.{name}\n\n{said(module)}\n\n| name | |\n|---|---|\n"
    return head + "\n".join(rows) + "\n"


def page() -> str:
    """The page."""
    return "\n".join([HEAD, *map(room, ROOMS)])


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
