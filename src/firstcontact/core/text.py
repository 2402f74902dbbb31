"""Text functions: numbers, plurals, and the escaping of untrusted text."""

from __future__ import annotations

import codecs
import math
import re

from firstcontact.core._errors import ArgumentError

#: Endings that take -es in the plural ("epoch" does not).
_ES = ("s", "x", "nch", "tch", "sh")
#: Control characters except tab and newline, characters that change the writing direction, and
#: surrogates, as in file names that are not UTF-8.
_CONTROL = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff]"
)
#: Name of the ``str.encode`` error handler for characters that an encoding lacks.
ESCAPE_ERRORS = "firstcontact.plain"
#: Largest number of decimals of a percentage.
MOST_DECIMALS = 2


def counted(number: int, noun: str) -> str:
    """Return a number with its noun, singular or plural: "1 pinch", "1,200 channels"."""
    return f"{number:,} {nouns(number, noun)}"


def nouns(number: int, noun: str) -> str:
    """Return a regular noun, in the plural unless ``number`` is 1."""
    if number == 1:
        return noun
    if noun.endswith("y") and noun[-2:-1] not in "aeiou":
        return noun[:-1] + "ies"
    return noun + ("es" if noun.endswith(_ES) else "s")


def percent(share: float, decimals: int = 1) -> str:
    """Return a share from 0 to 1 as text, such as "98.2 %". Only a share of 1 reads 100 %."""
    for places in range(decimals, MOST_DECIMALS + 1):
        text = f"{100 * share:.{places}f}"
        if share >= 1 or float(text) < 100:
            return f"{text} %"
    return "99.99 %"


def parse_float(text: str, *, finite: bool = True) -> float:
    """Convert a text such as "-1.5e3" to float. Raise ValueError for any other spelling.

    The error's message continues a sentence about the text: "which is not a number".
    """
    try:
        value = float(_plain_digits(text))
    except ValueError:
        raise ValueError("which is not a number") from None
    if finite and not math.isfinite(value):
        raise ValueError("which is not a finite number")
    return value


def parse_int(text: str) -> int:
    """Convert a text without a decimal point to int. Raise ValueError as :func:`parse_float`."""
    try:
        return int(_plain_digits(text))
    except ValueError:
        raise ValueError("which is not a whole number") from None


def _plain_digits(text: str) -> str:
    if "_" in text or not text.isascii():
        raise ValueError
    return text


def sanitize(text: str) -> str:
    r"""Return the text with control characters escaped as ``\u001b``, as JSON does."""
    return _CONTROL.sub(lambda match: f"\\u{ord(match[0]):04x}", text)


def one_line(text: str) -> str:
    r"""Return the text like :func:`sanitize`, with newlines escaped as ``\n`` too."""
    return sanitize(text).replace("\n", "\\n")


def summarize_error(error: BaseException) -> str:
    """Return the type and message of an exception in one line: "KeyError: 'name'"."""
    return " ".join(f"{type(error).__name__}: {error}".split()).removesuffix(":")


def check_text(text: object, parameter: str = "") -> None:
    """Raise ArgumentError unless ``text`` is a str that UTF-8 can store."""
    if not isinstance(text, str):
        raise ArgumentError(f"{text!r} is not a text: put it in quotes", parameter=parameter)
    try:
        text.encode()
    except UnicodeEncodeError as error:
        raise ArgumentError(
            f"{text!r} has characters that UTF-8 cannot store: remove them", parameter=parameter
        ) from error


def _escape(error: UnicodeError) -> tuple[str, int]:
    assert isinstance(error, UnicodeEncodeError)
    units = error.object[error.start : error.end].encode("utf-16-be", "surrogatepass")
    pairs = zip(units[::2], units[1::2], strict=True)
    return "".join(f"\\u{high:02x}{low:02x}" for high, low in pairs), error.end


codecs.register_error(ESCAPE_ERRORS, _escape)
