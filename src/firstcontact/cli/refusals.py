"""Errors of the option parser as one sentence, like all other errors.

tyro draws boxes and ends the process; it offers no errors as objects.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr
from io import StringIO

from firstcontact.core import InputError

#: Sides, corners and rules of a box, on terminals with and without such characters.
_SIDES, _CORNERS, _RULES = "│|", ("╭", "╰", "+"), "─-"
_GUESS, _HELP = "Perhaps you meant", ("For full helptext", "Argument helptext")


@contextmanager
def refusals(program: str) -> Iterator[None]:
    """Raise an InputError in place of tyro's box and the end of the process.

    Parameters
    ----------
    program
        Command and verb, whose help the error names.
    """
    printed = StringIO()
    try:
        with redirect_stderr(printed):
            yield
    except SystemExit as end:
        sentence = in_one_sentence(printed.getvalue())
        if not end.code or not sentence:
            sys.stderr.write(printed.getvalue())
            raise
        raise InputError(f"{sentence}; all options: `{program} --help`") from None
    sys.stderr.write(printed.getvalue())


def in_one_sentence(box: str) -> str:
    """Return the text of a box, without its frame, its title and the help."""
    parts: list[list[str]] = [[]]
    for line in box.splitlines():
        text = line.strip(_SIDES)
        if line.startswith(_CORNERS):
            continue
        if text.strip() and not text.strip().strip(_RULES):
            parts.append([])
        else:
            parts[-1].append(text)
    sentences = []
    for part in parts:
        first, *lines = [line for line in part if line.strip()] or [""]
        if first.strip().startswith(_GUESS):
            least = min((_indent(line) for line in lines), default=0)
            named = [line.strip() for line in lines if _indent(line) == least]
            sentences.append(f"perhaps you meant {' or '.join(named)}")
        elif not first.strip().startswith(_HELP):
            sentences.append(" ".join([first, *lines]))
    words = [" ".join(text.split()).rstrip(".").replace(". ", ": ") for text in sentences]
    return "; ".join(filter(None, words))


def _indent(line: str) -> int:
    return len(line) - len(line.lstrip())
