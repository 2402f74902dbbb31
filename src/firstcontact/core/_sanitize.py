"""Sanitise untrusted text for terminals and pages."""

from __future__ import annotations

import codecs
import re

from firstcontact.core._errors import InputError

#: Control characters except tab and newline, characters that change the writing direction, and
#: surrogates, as in file names that are not UTF-8.
_CONTROL = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff]"
)
#: Name of the ``str.encode`` error handler for characters that an encoding lacks.
ESCAPE_ERRORS = "firstcontact.plain"


def sanitize(text: str) -> str:
    r"""Return the text with control characters escaped as ``\u001b``, as JSON does."""
    return _CONTROL.sub(lambda match: f"\\u{ord(match[0]):04x}", text)


def one_line(text: str) -> str:
    r"""Return the text like :func:`sanitize`, with newlines escaped as ``\n`` too."""
    return sanitize(text).replace("\n", "\\n")


def check_text(text: object, parameter: str = "") -> None:
    """Raise an error for a value that no recording could store as text.

    Raises
    ------
    InputError
        The value is no text, or contains surrogates, which stand for bytes that are not UTF-8.
    """
    if not isinstance(text, str):
        raise InputError(f"{text!r} is no text: put it in quotes", parameter=parameter)
    try:
        text.encode()
    except UnicodeEncodeError as error:
        raise InputError(
            f"{text!r} is not text in UTF-8: type it again", parameter=parameter
        ) from error


def _lacking(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    units = error.object[error.start : error.end].encode("utf-16-be", "surrogatepass")
    pairs = zip(units[::2], units[1::2], strict=True)
    return "".join(f"\\u{high:02x}{low:02x}" for high, low in pairs), error.end


codecs.register_error(ESCAPE_ERRORS, _lacking)
