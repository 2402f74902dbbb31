"""Text from outside as it may be shown: nothing in it moves a cursor or hides what it says."""

from __future__ import annotations

import codecs
import re

from firstcontact.core._errors import InputError

#: Control characters but tab and newline, what turns the direction of writing, and
#: halves of characters, as file names that are not UTF-8 have them.
_CONTROL = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff]"
)
#: Name of the handler of characters that an encoding lacks, for ``str.encode``.
ESCAPE_ERRORS = "firstcontact.plain"


def sanitize(text: str) -> str:
    r"""The text with control characters as ``\u001b``: in JSON, still the same text."""
    return _CONTROL.sub(lambda found: f"\\u{ord(found[0]):04x}", text)


def one_line(text: str) -> str:
    r"""As :func:`sanitize`, with newlines as ``\n``, too."""
    return sanitize(text).replace("\n", "\\n")


def check_text(text: str) -> None:
    """Refuse what a command line gave that is not UTF-8: no recording could hold it.

    Raises
    ------
    InputError
        It has halves of characters in it.
    """
    try:
        text.encode()
    except UnicodeEncodeError as error:
        raise InputError(f"{text!r} is not text in UTF-8: write it anew") from error


def _lacking(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    units = error.object[error.start : error.end].encode("utf-16-be", "surrogatepass")
    pairs = zip(units[::2], units[1::2], strict=True)
    return "".join(f"\\u{high:02x}{low:02x}" for high, low in pairs), error.end


codecs.register_error(ESCAPE_ERRORS, _lacking)
