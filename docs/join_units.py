"""Hook of MkDocs that keeps a number and its unit on one line in tables."""

from __future__ import annotations

import re
from typing import Any

CELL = re.compile(r"<t[dh][ >].*?</t[dh]>", re.DOTALL)
CODE = re.compile(r"(<code>.*?</code>)", re.DOTALL)
#: Space between a number and its unit.
SPACE = re.compile(
    r"(?<=\d) (?=[%×]|(?:m?s|µs|min|[kM]?Hz|[mc]?m|[mk]?g|[km]?N|m?V|[km]?Ω|[nµ]F|[kMG]B|Shore)\b)"
)


def join_units(html: str) -> str:
    """Return a page whose table cells have no-break spaces before units, except in code."""
    return CELL.sub(lambda cell: _outside_code(cell[0]), html)


def on_page_content(html: str, **_: Any) -> str:
    """Change the content of a page. MkDocs calls this function for each page."""
    return join_units(html)


def _outside_code(cell: str) -> str:
    parts = CODE.split(cell)
    parts[::2] = [SPACE.sub("\u00a0", part) for part in parts[::2]]
    return "".join(parts)
