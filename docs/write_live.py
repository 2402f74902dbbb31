"""Write the tables of JSON lines in docs/reference/live-output.md from the event structs.

python docs/write_live.py
"""

from __future__ import annotations

import inspect
import re
from pathlib import Path
from typing import get_args

import msgspec

from firstcontact.device import Health
from firstcontact.streaming import Event, HandCheck
from firstcontact.streaming.json_lines import (
    ChannelLine,
    DescriptorLine,
    FailedLine,
    LinkLine,
    MarkerLine,
)
from firstcontact_lab.report.tables import fill, markdown_table

PAGE = Path(__file__).parent / "reference" / "live-output.md"
#: Types of lines, in the order of the page, and the records inside them.
LINES = (DescriptorLine, *get_args(Event), MarkerLine, LinkLine, FailedLine)
PARTS = {"channels of the descriptor": ChannelLine, "check of a hand_pinch": HandCheck}


def section(kind: type, heading: str = "") -> str:
    """Return heading, summary and table of fields of one record."""
    text = inspect.cleandoc(kind.__doc__ or "")
    summary, _, details = text.partition("\n\n")
    config = getattr(kind, "__struct_config__", None)
    tag = None if config is None else config.tag
    rows = [("`type`", f"`{tag}`")] if tag else []
    documented = parameters(details)
    if kind is LinkLine:
        health = parameters(inspect.cleandoc(Health.__doc__ or ""))
        documented = {f.name: health[f.name] for f in msgspec.structs.fields(LinkLine)}
    fields = [name for names in documented for name in names.split(", ")]
    if config is not None:
        declared = [field.name for field in msgspec.structs.fields(kind)]
        if fields != declared:
            raise SystemExit(f"{kind.__name__}: the docstring lists {fields}, and not {declared}")
    for names, meaning in documented.items():
        words = ", ".join(f"`{name}`" for name in names.split(", "))
        rows.append((words, meaning))
    table = markdown_table("field | meaning", rows)
    return f"### {heading or tag}\n\n{plain(summary)}.\n\n{table}"


def parameters(text: str) -> dict[str, str]:
    """Return the parameters of a docstring and their meanings."""
    _, _, text = text.partition("Parameters\n----------\n")
    documented: dict[str, list[str]] = {}
    for line in text.split("\n\n")[0].splitlines():
        if not line.startswith(" "):
            documented[line] = []
        else:
            documented[list(documented)[-1]].append(line.strip())
    return {names: plain(" ".join(words)) for names, words in documented.items()}


def plain(text: str) -> str:
    """Return text of a docstring for a table."""
    text = re.sub(r":\w+:`(?:[\w.]+\.)?(\w+)`", r"`\1`", " ".join(text.split()))
    return text.replace("``", "`").rstrip(".")


def filled(text: str) -> str:
    """Return the page with new tables."""
    parts = [section(kind, heading) for heading, kind in PARTS.items()]
    return fill(text, "live", {"lines": "\n".join([*map(section, LINES), *parts])})


if __name__ == "__main__":
    PAGE.write_text(filled(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
