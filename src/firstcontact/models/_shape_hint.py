"""Shape hints: radius of an object where it is touched, as a person states it."""

from __future__ import annotations

import math

from firstcontact.core import InputError, parse_float

FLAT = "flat"
#: Least and largest radius that can be told, mm: rounder ones were not learned from, and what is
#: less curved is flat.
LEAST, MOST = 5.0, 200.0


def radius_of(text: str) -> float:
    """Return the radius in m of a hint, "flat" or a number of mm; infinite for flat.

    NaN where nothing is told, as by "".

    Raises
    ------
    InputError
        Neither, or a radius beyond what was learned from.
    """
    word = text.strip().lower()
    if not word:
        return math.nan
    if word == FLAT:
        return math.inf
    try:
        radius = parse_float(word.removesuffix("mm"))
    except ValueError:
        radius = math.nan
    if not LEAST <= radius <= MOST:
        raise InputError(
            f"the shape {text.strip()!r} cannot be told: give {FLAT}, or a radius "
            f"from {LEAST:g} to {MOST:g} mm"
        )
    return radius / 1000


def in_words(radius: float | None) -> str:
    """Return the hint of a radius as text, "" for None or NaN."""
    if radius is None or math.isnan(radius):
        return ""
    return FLAT if math.isinf(radius) else f"radius {1000 * radius:g} mm"
