"""Tables in Markdown, and the places for them in a page."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence


def table(head: str, rows: Iterable[Sequence[str]]) -> str:
    """Return a table as Markdown. The head has its columns between bars."""
    rule = "|" + "---|" * (head.count("|") + 1)
    return "\n".join([f"| {head} |", rule, *(f"| {' | '.join(row)} |" for row in rows)])


def fill(text: str, made: Mapping[str, str]) -> str:
    """Return a page with the tables between ``<!-- hardware: NAME -->`` and its end replaced."""
    pattern = r"(<!-- hardware: (\w+) -->\n\n).*?(\n\n<!-- /hardware -->)"
    return re.sub(pattern, lambda m: m[1] + made[m[2]] + m[3], text, flags=re.DOTALL)
