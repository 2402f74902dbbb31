"""What the parser of options refuses, as the one sentence that all errors are.

tyro draws boxes and ends the process; there is no public way to have its errors as objects.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr
from io import StringIO

from firstcontact.core import InputError

#: Sides, corners and rules of a box, where the terminal has such characters and where not.
_SIDES, _CORNERS, _RULES = "│|", ("╭", "╰", "+"), "─-"
_GUESS, _HELP = "Perhaps you meant", ("For full helptext", "Argument helptext")


@contextmanager
def refusals(program: str) -> Iterator[None]:
    """Turn the end of the process that tyro's box comes with into an InputError.

    Parameters
    ----------
    program
        The command and its verb, whose help is named as the remedy.
    """
    said = StringIO()
    try:
        with redirect_stderr(said):
            yield
    except SystemExit as end:
        sentence = in_one_sentence(said.getvalue())
        if not end.code or not sentence:
            sys.stderr.write(said.getvalue())
            raise
        raise InputError(f"{sentence}; all options: `{program} --help`") from None
    sys.stderr.write(said.getvalue())


def in_one_sentence(box: str) -> str:
    """What a box says, without its frame, its title, and the text of the help."""
    parts: list[list[str]] = [[]]
    for line in box.splitlines():
        text = line.strip(_SIDES)
        if line.startswith(_CORNERS):
            continue
        if text.strip() and not text.strip().strip(_RULES):
            parts.append([])
        else:
            parts[-1].append(text)
    said = []
    for part in parts:
        first, *others = [line for line in part if line.strip()] or [""]
        if first.strip().startswith(_GUESS):
            least = min((_indent(line) for line in others), default=0)
            named = [line.strip() for line in others if _indent(line) == least]
            said.append(f"perhaps you meant {' or '.join(named)}")
        elif not first.strip().startswith(_HELP):
            said.append(" ".join([first, *others]))
    words = [" ".join(text.split()).rstrip(".").replace(". ", ": ") for text in said]
    return "; ".join(filter(None, words))


def _indent(line: str) -> int:
    return len(line) - len(line.lstrip())
