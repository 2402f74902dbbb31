"""Symbols of the schematics. Lengths are in steps of KiCad's grid, 2.54 mm; y points up."""

from __future__ import annotations

from typing import NamedTuple

from circuit import CABLE, Kind, Part
from sexpr import Element, Word

GRID = 2.54
LIBRARY = "firstcontact"
FLAG = "PWR_FLAG"


class Pin(NamedTuple):
    """Pin of a symbol. The position is its free end."""

    number: str
    at: tuple[float, float]
    angle: int
    """Direction from the free end to the body, in degrees anticlockwise."""
    length: float = 0.5
    type: str = "passive"
    name: str = ""


class Symbol(NamedTuple):
    """Drawing of a part, or of one unit of it."""

    pins: tuple[Pin, ...]
    lines: tuple[tuple[tuple[float, float], ...], ...] = ()
    circles: tuple[tuple[float, float, float], ...] = ()
    """Middle and radius."""
    unit: int = 1


def _box(x: float, top: float, bottom: float | None = None) -> tuple[tuple[float, float], ...]:
    low = -top if bottom is None else bottom
    return ((-x, top), (x, top), (x, low), (-x, low), (-x, top))


_ENDS = (Pin("1", (0, 1.5), 270), Pin("2", (0, -1.5), 90))
_RESISTOR = Symbol(_ENDS, (_box(0.4, 1.0),))
_CAPACITOR = Symbol(
    (Pin("1", (0, 1.5), 270, 1.2), Pin("2", (0, -1.5), 90, 1.2)),
    (((-0.8, 0.3), (0.8, 0.3)), ((-0.8, -0.3), (0.8, -0.3))),
)


def _diode(y: float) -> tuple[tuple[tuple[float, float], ...], ...]:
    """Return the lines of a diode's symbol that conducts upwards, at the height ``y``."""
    triangle = ((-0.5, y - 0.45), (0.5, y - 0.45), (0, y + 0.45), (-0.5, y - 0.45))
    return (triangle, ((-0.5, y + 0.45), (0.5, y + 0.45)))


_DIODES = Symbol(
    (Pin("1", (0, -3), 90, 1.95), Pin("2", (0, 3), 270, 1.95), Pin("3", (0, 0), 0, 0)),
    (*_diode(1.5), *_diode(-1.5), ((0, 1.05), (0, -1.05)), ((0, 2), (0, 1.9))),
)


def _amplifier(unit: int, plus: str, minus: str, out: str) -> Symbol:
    triangle = ((-2, 2), (2, 0), (-2, -2), (-2, 2))
    marks = (((-1.7, 1), (-1.1, 1)), ((-1.4, 1.3), (-1.4, 0.7)), ((-1.7, -1), (-1.1, -1)))
    return Symbol(
        (
            Pin(plus, (-3, 1), 0, 1, "input", "+"),
            Pin(minus, (-3, -1), 0, 1, "input", "-"),
            Pin(out, (3, 0), 180, 1, "output", "out"),
        ),
        (triangle, *marks),
        unit=unit,
    )


_POWER = Symbol(
    (Pin("4", (0, 3), 270, 1, "power_in", "VDD"), Pin("11", (0, -3), 90, 1, "power_in", "VSS")),
    (((0, 2), (0, 1)), ((0, -2), (0, -1)), ((-2, 2), (2, 0), (-2, -2), (-2, 2))),
    unit=5,
)
_AMPLIFIERS = (
    _amplifier(1, "3", "2", "1"),
    _amplifier(2, "5", "6", "7"),
    _amplifier(3, "10", "9", "8"),
    _amplifier(4, "12", "13", "14"),
    _POWER,
)
_CONNECTOR = Symbol(
    tuple(
        Pin(str(n), (3, 5 - n), 180, 1, name=wire.replace("_", " "))
        for n, wire in enumerate(CABLE, 1)
    ),
    (_box(2, 5),),
)


def _teensy() -> Symbol:
    """Return the Teensy: analog pins on the left, digital pins on the right."""
    left = [
        Pin(str(n), (-6, 19.5 - n - 2), 0, 1, "input", f"A{n - 14}") for n in range(14, 20)
    ]  # fmt: skip
    right = [Pin(str(n), (6, 6 - n - 0.5), 180, 1, "bidirectional", f"D{n}") for n in range(2, 10)]
    power = [
        Pin("3V3", (0, 6), 270, 1, "power_out"), Pin("GND", (0, -6), 90, 1, "power_out"),
    ]  # fmt: skip
    return Symbol((*left, *right, *power), (_box(5, 5),))


_POINT = Symbol((Pin("1", (0, 0), 90, 0.5),), circles=((0, 0.8, 0.3),))
_PAD = Symbol((Pin("1", (1.5, 0), 180, 1),), circles=((0, 0, 0.5),))
_DISC = Symbol(
    (Pin("1", (0, 1.5), 270, 0.8), Pin("2", (0, -1.5), 90, 0.8)),
    (((-0.9, 0.7), (0.9, 0.7)), _box(0.7, 0.4), ((-0.9, -0.7), (0.9, -0.7))),
)
_TAXEL = Symbol(_ENDS, (_box(0.4, 1.0), ((-0.9, -0.9), (-0.6, -0.9), (0.8, 0.9))))
#: Symbols of the power nets, which name their net.
POWER = {
    "gnd": Symbol(
        (Pin("1", (0, 0), 270, 0, "power_in"),),
        (((0, 0), (0, -0.4)), ((-0.5, -0.4), (0.5, -0.4), (0, -0.9), (-0.5, -0.4))),
    ),
    "3v3": Symbol(
        (Pin("1", (0, 0), 90, 0, "power_in"),), (((0, 0), (0, 0.5)), ((-0.5, 0.5), (0.5, 0.5)))
    ),
    # Tells KiCad that a net gets its power from a cable. It names no net.
    FLAG: Symbol(
        (Pin("1", (0, 0), 90, 0, "power_out"),),
        (((0, 0), (0, 0.4), (-0.4, 0.7), (0, 1.0), (0.4, 0.7), (0, 0.4)),),
    ),
}


def symbol_name(part: Part) -> str:
    """Return the name of a part's symbol in the schematic's library."""
    names = {
        Kind.RESISTOR: "resistor", Kind.CAPACITOR: "capacitor", Kind.DIODES: "diodes",
        Kind.AMPLIFIER: "amplifiers", Kind.CONNECTOR: "connector", Kind.BOARD: "teensy",
        Kind.TEST_POINT: "point", Kind.TAXEL: "taxel", Kind.DISC: "disc",
    }  # fmt: skip
    return names.get(part.kind, "connector" if len(part.pins) > 1 else "pad")


#: Units of each symbol.
SYMBOLS = {
    "resistor": (_RESISTOR,), "capacitor": (_CAPACITOR,), "diodes": (_DIODES,),
    "amplifiers": _AMPLIFIERS, "connector": (_CONNECTOR,), "teensy": (_teensy(),),
    "point": (_POINT,), "pad": (_PAD,), "taxel": (_TAXEL,), "disc": (_DISC,),
}  # fmt: skip
#: Symbols whose pins show their name, or their number.
_NAMED = {"connector", "teensy"}
_NUMBERED = {"amplifiers", "connector", "teensy"}


def _mm(length: float) -> float:
    return round(length * GRID, 4)


def _word(name: str, *rest: Element) -> list[Element]:
    return [Word(name), *rest]


def text_size(size: float = 1.27, *more: Element) -> list[Element]:
    """Return the S-expression for the size of a text, mm, and for ``more`` effects."""
    return _word("effects", _word("font", _word("size", size, size)), *more)


def definition(name: str, units: tuple[Symbol, ...], *, is_power: bool = False) -> list[Element]:
    """Return the S-expression of a symbol, as a schematic embeds it."""
    hide = _word("hide", Word("yes"))
    stroke = _word("stroke", _word("width", 0.1524), _word("type", Word("default")))
    empty = _word("fill", _word("type", Word("none")))
    result = _word("symbol", f"{LIBRARY}:{name}")
    if is_power:
        result.append(_word("power"))
    if name not in _NUMBERED:
        result.append(_word("pin_numbers", hide))
    names = _word("pin_names", _word("offset", 0.508))
    result.append(names if name in _NAMED else [*names, hide])
    result += [
        _word("exclude_from_sim", Word("no")), _word("in_bom", Word("yes")),
        _word("on_board", Word("yes")),
    ]  # fmt: skip
    for key, value in (
        ("Reference", "#PWR" if is_power else "X"),
        ("Value", name),
        ("Footprint", ""),
        ("Datasheet", ""),
        ("Description", ""),
    ):
        result.append(_word("property", key, value, _word("at", 0, 0, 0), text_size(1.27, hide)))
    for unit in units:
        body = _word("symbol", f"{name}_{unit.unit}_1")
        for line in unit.lines:
            points = _word("pts", *(_word("xy", _mm(x), _mm(y)) for x, y in line))
            body.append(_word("polyline", points, stroke, empty))
        for x, y, radius in unit.circles:
            body.append(
                _word(
                    "circle",
                    _word("center", _mm(x), _mm(y)),
                    _word("radius", _mm(radius)),
                    stroke,
                    empty,
                )
            )
        for pin in unit.pins:
            body.append(
                _word(
                    "pin", Word(pin.type), Word("line"),
                    _word("at", _mm(pin.at[0]), _mm(pin.at[1]), pin.angle),
                    _word("length", _mm(pin.length)),
                    _word("name", pin.name or "~", text_size()),
                    _word("number", pin.number, text_size()),
                )
            )  # fmt: skip
        result.append(body)
    return result
