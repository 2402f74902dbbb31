"""Units of recorded signals: parsers of unit names, and checks if numbers can have a unit."""

from __future__ import annotations

import re
import unicodedata
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core._errors import FileError, InputError
from firstcontact.core.layout import ADC_COUNTS, ADC_VOLTS

#: Unit of the signals that the package's own models were trained on.
VOLTS = "V"
#: Remedy for an unknown or wrong unit.
STATE_UNIT = (
    "state the unit, such as V, mV, uV, g, m/s2, or '12 bits over 3.3 V' for a converter's numbers"
)
#: Largest voltage of a force, V, and largest swing of a vibration in each unit.
MOST_FORCE = 10.0
MOST_SWING = {VOLTS: 100.0, "m/s2": 2e6, "Pa": 1e7, "full scale": 2.1}
#: Most bits of a converter.
MOST_BITS = 32

_PREFIXES = {"n": 1e-9, "u": 1e-6, "m": 1e-3, "k": 1e3}
_PREFIXES |= {"nano": 1e-9, "micro": 1e-6, "milli": 1e-3, "kilo": 1e3, "": 1.0}
#: Spellings of each unit, in lower case, with the unit's name and size.
_UNITS = {
    **dict.fromkeys(("v", "volt", "volts"), (VOLTS, 1.0)),
    **dict.fromkeys(("pa", "pascal", "pascals"), ("Pa", 1.0)),
    **dict.fromkeys(("m/s2", "m/s^2", "m/s/s", "ms-2"), ("m/s2", 1.0)),
    "g": ("m/s2", 9.80665),
}
_OTHERS = {"full scale": "full scale", "fullscale": "full scale", "fs": "full scale"}
_COUNTS = {"count", "counts"}
_CONVERTER = re.compile(r"(\d{1,2}) ?-?bits?(?: counts)?(?: ?(?:over|/|) ?(\d+(?:\.\d+)?) ?v)?")
#: Unit at the end of a name: "piezo_mV", "piezo (mV)" or "piezo[mV]".
_ENDING = re.compile(r".*?(?:_|\s*[(\[])([^_()\[\]]+)[)\]]?")


@dataclass(frozen=True, slots=True)
class Unit:
    """Unit of recorded numbers: ``(number - offset) * scale`` is the value in the unit ``name``.

    ``bits`` is the resolution if the numbers are counts of an analog-to-digital converter, else
    None. ``is_assumed`` is True if the user did not state the resolution.
    """

    name: str
    scale: float = 1.0
    offset: float = 0.0
    bits: int | None = None
    is_assumed: bool = False


def converter(bits: int, volts: float, *, is_assumed: bool = False) -> Unit:
    """Return the unit of an analog-to-digital converter's counts.

    The converter reads 0 to ``volts``. Its input rests at half the range, which becomes 0 V.
    """
    steps = 2.0**bits
    return Unit(VOLTS, volts / steps, steps / 2, bits, is_assumed)


VOLT = Unit(VOLTS)
#: What "counts" alone mean.
COUNTS = converter(ADC_COUNTS.bit_length() - 1, ADC_VOLTS, is_assumed=True)


def plain_unit(text: str) -> str:
    """Return the text of a unit without brackets and with plain letters: "u" for a Greek mu."""
    plain = unicodedata.normalize("NFKC", text).replace("\u03bc", "u")
    return " ".join(plain.strip().strip("()[]").split())


def parse_unit(text: str) -> Unit | None:
    """Return the unit that a text names; None if it is unknown."""
    text = plain_unit(text)
    lower = text.lower()
    if lower in _COUNTS:
        return COUNTS
    if match := _CONVERTER.fullmatch(lower):
        bits, volts = int(match[1]), float(match[2] or ADC_VOLTS)
        return converter(bits, volts) if 1 <= bits <= MOST_BITS and volts > 0 else None
    if lower in _OTHERS:
        return Unit(_OTHERS[lower])
    for prefix, factor in _PREFIXES.items():
        # The case of a letter counts: MPa are not mPa.
        start = text[: len(prefix)] if len(prefix) == 1 else lower[: len(prefix)]
        if start == prefix and (known := _UNITS.get(lower[len(prefix) :])):
            return Unit(known[0], known[1] * factor)
    return None


def known_unit(text: str) -> Unit:
    """Return the unit that a text names; for an unknown unit, one that converts nothing."""
    unit = parse_unit(text)
    return Unit(text) if unit is None or unit.is_assumed else unit


def unit_of_name(name: str) -> Unit | None:
    """Return the unit at the end of a column's name, such as "piezo_mV"; None without one."""
    match = _ENDING.fullmatch(name)
    return parse_unit(match[1]) if match else None


def fit_unit(
    origin: str,
    unit: Unit,
    values: NDArray[Any],
    *,
    is_force: bool = False,
    error: type[InputError] = FileError,
) -> Unit:
    """Check if recorded numbers can have a unit. Return the unit, with its offset corrected.

    ``values`` are numbers of a vibration, or of a force, shape (samples, columns). The offset
    becomes 0 for counts of a converter with stated bits that lie around 0. Raises ``error``, with
    the name ``origin``, if the numbers cannot have this unit.
    """
    if not values.size:
        return unit
    low, high = float(values.min()), float(values.max())
    if unit.bits is None:
        swing = float(np.ptp(values.astype(np.float64), axis=0).max())
        largest = unit.scale * (max(-low, high) if is_force else swing)
        most = MOST_FORCE if is_force else MOST_SWING.get(unit.name, np.inf)
        if largest > most:
            raise error(
                f"{origin} {'reaches' if is_force else 'swings by'} {largest:g} {unit.name}, but a "
                f"sensor gives at most {most:g} {unit.name}: {STATE_UNIT}"
            )
        return unit
    top = 2**unit.bits
    if low < 0 and not (is_force or unit.is_assumed) and -top / 2 <= low and high < top / 2:
        return replace(unit, offset=0.0)
    if low < 0 or high >= top:
        raise error(
            f"{origin} has numbers from {low:g} to {high:g}, but a converter of {unit.bits} bits "
            f"gives 0 to {top - 1}: {STATE_UNIT}"
        )
    rest = float(np.median(values))
    if unit.is_assumed and not is_force and abs(rest - top / 2) > top / 4:
        raise error(
            f"{origin} rests at {rest:g}, but 'counts' mean a converter of {unit.bits} bits, which "
            f"rests at {top // 2}: {STATE_UNIT}"
        )
    return unit
