"""Writer of KiCad schematics from a plan, and reader of their nets."""

from __future__ import annotations

import itertools
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from circuit import Kind, Part
from layout import REVISION
from project import path_id
from sexpr import Element, Word, all_of, numbers, one_of, parse, property_of, write
from symbols import FLAG, GRID, LIBRARY, POWER, SYMBOLS, definition, symbol_name, text_size

Point = tuple[float, float]
#: Kinds that nobody buys to put them on the board.
NOT_BOUGHT = (Kind.TAXEL, Kind.PADS, Kind.TEST_POINT, Kind.DISC)


@dataclass(frozen=True)
class Put:
    """Symbol on a sheet. Positions are in steps of the grid; y points down."""

    reference: str
    at: Point
    angle: int = 0
    unit: int = 1


@dataclass(frozen=True)
class Wire:
    """Wire through pins such as ``R1.2`` and points (x, y). None keeps the coordinate before."""

    stops: tuple[str | tuple[float | None, float | None], ...]


@dataclass(frozen=True)
class Label:
    """Name of a net at the end of a wire. A power net gets a symbol instead."""

    net: str
    at: Point | str
    angle: int = 0


@dataclass(frozen=True)
class Sheet:
    """Plan of a schematic: symbols, wires, labels and notes."""

    name: str
    title: str
    puts: tuple[Put, ...]
    wires: tuple[Wire, ...]
    labels: tuple[Label, ...]
    notes: tuple[tuple[str, Point], ...] = ()
    paper: str = "A4"


def _turned(x: float, y: float, angle: int) -> Point:
    """Return a point of a turned symbol (y up) in the sheet's directions (y down)."""
    for _ in range(angle // 90 % 4):
        x, y = -y, x
    return x, -y


def _word(name: str, *rest: Element) -> list[Element]:
    return [Word(name), *rest]


def _at(point: Point, angle: int | None = None) -> list[Element]:
    place = _word("at", round(point[0] * GRID, 4), round(point[1] * GRID, 4))
    return place if angle is None else [*place, angle]


class _Writer:
    """Writer that makes a schematic from its plan."""

    def __init__(self, sheet: Sheet, table: Iterable[Part]):
        self.sheet, self.table = sheet, {part.reference: part for part in table}
        self.pins: dict[str, Point] = {}
        for put in sheet.puts:
            for unit in SYMBOLS[symbol_name(self.table[put.reference])]:
                if unit.unit == put.unit:
                    for pin in unit.pins:
                        dx, dy = _turned(*pin.at, put.angle)
                        place = round(put.at[0] + dx, 3), round(put.at[1] + dy, 3)
                        self.pins[f"{put.reference}.{pin.number}"] = place
        self.root = path_id(sheet.name)
        self.count = itertools.count()

    def id(self, *names: str) -> list[Element]:
        return _word("uuid", path_id(self.sheet.name, *(names or (f"item {next(self.count)}",))))

    def expression(self) -> list[Element]:
        """Return the whole schematic as an S-expression."""
        used = sorted({symbol_name(part) for part in self.table.values()})
        library = [definition(name, SYMBOLS[name]) for name in used]
        library += [definition(name, (symbol,), is_power=True) for name, symbol in POWER.items()]
        whole = [pair for wire in self.sheet.wires for pair in self._segments(wire)]
        junctions = self._junctions(whole)
        segments = [part for pair in whole for part in _split(pair, junctions)]
        return _word(
            "kicad_sch", _word("version", 20250114), _word("generator", "firstcontact"),
            _word("generator_version", "9.0"), _word("uuid", self.root),
            _word("paper", self.sheet.paper),
            _word(
                "title_block", _word("title", self.sheet.title), _word("rev", REVISION),
                _word("comment", 1, "CERN-OHL-P-2.0. Nobody has built it yet."),
                _word("comment", 2, "Written by hardware/write_schematics.py"),
            ),
            _word("lib_symbols", *library),
            *(_word("junction", _at(p), _word("diameter", 0), self.id()) for p in junctions),
            *(
                _word("wire", _word("pts", *(_word("xy", *_at(p)[1:]) for p in pair)),
                      _word("stroke", _word("width", 0), _word("type", Word("default"))), self.id())
                for pair in segments
            ),
            *(self._label(label) for label in self.sheet.labels),
            *(
                _word("text", words, _word("exclude_from_sim", Word("no")), [*_at(place), 0],
                      text_size(2.0, _word("justify", Word("left"))), self.id())
                for words, place in self.sheet.notes
            ),
            *(self._symbol(put) for put in self.sheet.puts),
            _word("sheet_instances", _word("path", "/", _word("page", "1"))),
            _word("embedded_fonts", Word("no")),
        )  # fmt: skip

    def _place(self, stop: str | tuple[float | None, float | None], before: Point | None) -> Point:
        if isinstance(stop, str):
            return self.pins[stop]
        x, y = stop
        if before is None and (x is None or y is None):
            raise ValueError("a wire begins with a pin or a whole point")
        return (before[0] if x is None else x), (before[1] if y is None else y)  # type: ignore[index]

    def _segments(self, wire: Wire) -> list[tuple[Point, Point]]:
        points: list[Point] = []
        for stop in wire.stops:
            points.append(self._place(stop, points[-1] if points else None))
        for a, b in itertools.pairwise(points):
            if a[0] != b[0] and a[1] != b[1]:
                raise ValueError(f"the wire {wire.stops} is not straight from {a} to {b}")
        return [pair for pair in itertools.pairwise(points) if pair[0] != pair[1]]

    def _junctions(self, segments: list[tuple[Point, Point]]) -> list[Point]:
        ends: dict[Point, int] = defaultdict(int)
        for point in [*itertools.chain(*segments), *self.pins.values()]:
            ends[point] += 1
        return sorted(
            point for point, count in ends.items()
            if count >= 3 or (count and any(_is_within(point, s) for s in segments))
        )  # fmt: skip

    def _label(self, label: Label) -> list[Element]:
        at = self._place(label.at, None)
        if label.net in POWER:
            return self._power(label.net, at, label.angle)
        side = "right" if label.angle in (180, 270) else "left"
        return _word(
            "label", label.net, [*_at(at), label.angle],
            text_size(1.27, _word("justify", Word(side), Word("bottom"))), self.id(),
        )  # fmt: skip

    def _power(self, net: str, at: Point, angle: int) -> list[Element]:
        number = next(self.count)
        reference, up = f"#PWR{number:03d}", (1.4 if net == "gnd" else -1.1)
        value = at[0], at[1] + (-up if angle else up)
        return self._instance(
            net, at, angle, 1, reference,
            {"Reference": (reference, at, True), "Value": (net, value, net == FLAG)},
            self.id(), in_bom=True, pins=("1",), centred=True,
        )  # fmt: skip

    def _symbol(self, put: Put) -> list[Element]:
        part, (x, y) = self.table[put.reference], put.at
        name = symbol_name(part)
        unit = next(u for u in SYMBOLS[name] if u.unit == put.unit)
        tall = max((abs(py) for line in unit.lines for _, py in line), default=1.0)
        if put.angle % 180:
            places = (x, y - 1.1), (x, y + 1.1)
        elif part.kind is Kind.AMPLIFIER and unit.unit == 5:
            places = (x - 8.0, y - 0.4), (x - 8.0, y + 0.4)
        elif len(unit.pins) > 2 or name == "pad":
            places = (x, y - tall - 1.2), (x, y - tall - 0.5)
            if part.kind is Kind.AMPLIFIER:
                places = (x + 0.3, y - 2.4), (x + 0.3, y - 1.7)
            elif part.kind is Kind.DIODES:
                places = (x + 0.9, y + 1.2), (x + 0.9, y + 2.0)
            elif part.kind is Kind.BOARD:
                places = (x - 5, y - 6.2), (x - 5, y - 5.5)
        else:
            places = (x + 0.8, y - 0.4), (x + 0.8, y + 0.4)
        centred = bool(put.angle % 180) or name in ("connector", "pad")
        fields: dict[str, tuple[str, Point, bool]] = {
            "Reference": (put.reference, places[0], False),
            "Value": (part.label, places[1], part.kind is Kind.TEST_POINT),
            "Footprint": (part.footprint, put.at, True),
            "Datasheet": ("", put.at, True),
            "Description": (part.purpose, put.at, True),
            "MPN": (part.number, put.at, True),
        }
        identifier = (put.reference,) if put.unit == 1 else (put.reference, str(put.unit))
        return self._instance(
            name, put.at, put.angle, put.unit, put.reference, fields, self.id(*identifier),
            in_bom=part.kind not in NOT_BOUGHT, pins=tuple(p.number for p in unit.pins),
            centred=centred,
        )  # fmt: skip

    def _instance(
        self, name: str, at: Point, angle: int, unit: int, reference: str,
        fields: dict[str, tuple[str, Point, bool]], identifier: list[Element], *,
        in_bom: bool, pins: tuple[str, ...], centred: bool,
    ) -> list[Element]:  # fmt: skip
        yes, no = Word("yes"), Word("no")
        shown = [] if centred else [_word("justify", Word("left"))]
        hidden = [_word("hide", yes)]
        return _word(
            "symbol", _word("lib_id", f"{LIBRARY}:{name}"), [*_at(at), angle], _word("unit", unit),
            _word("exclude_from_sim", no), _word("in_bom", yes if in_bom else no),
            _word("on_board", yes), _word("dnp", no), identifier,
            *(
                _word("property", key, value, [*_at(place), angle % 180],
                      text_size(1.27, *(hidden if is_hidden else shown)))
                for key, (value, place, is_hidden) in fields.items()
            ),
            *(_word("pin", pin, self.id()) for pin in pins),
            _word("instances", _word("project", self.sheet.name, _word(
                "path", f"/{self.root}", _word("reference", reference), _word("unit", unit)))),
        )  # fmt: skip


def _split(segment: tuple[Point, Point], junctions: list[Point]) -> list[tuple[Point, Point]]:
    """Return the pieces of a wire between the junctions on it."""
    (ax, ay), _ = segment
    inner = sorted(
        (p for p in junctions if _is_within(p, segment)),
        key=lambda p: abs(p[0] - ax) + abs(p[1] - ay),
    )
    points = [segment[0], *inner, segment[1]]
    return list(itertools.pairwise(points))


def _is_within(point: Point, segment: tuple[Point, Point]) -> bool:
    """Return True if a point lies within a horizontal or vertical segment, not at its ends."""
    (ax, ay), (bx, by) = segment
    x, y = point
    inside = min(ax, bx) <= x <= max(ax, bx) and min(ay, by) <= y <= max(ay, by)
    return inside and point not in segment


def write_schematic(sheet: Sheet, table: Iterable[Part], file: Path) -> None:
    """Write a schematic file from its plan and the table of parts."""
    file.write_text(write(_Writer(sheet, table).expression()) + "\n", "utf-8")


def read_nets(file: Path) -> dict[str, str]:
    """Return the net of each pin, such as ``R1.2``, from a schematic's wires and labels."""
    sheet = parse(file.read_text("utf-8"))
    shapes = {s[1]: s for s in all_of(one_of(sheet, "lib_symbols"), "symbol")}
    places: dict[str, Point] = {}
    names: list[tuple[Point, str]] = []
    for symbol in all_of(sheet, "symbol"):
        x, y, angle = numbers(one_of(symbol, "at"))
        shape = shapes[one_of(symbol, "lib_id")[1]]
        unit = one_of(symbol, "unit")[1]
        for body in all_of(shape, "symbol"):
            if body[1].split("_")[-2] not in ("0", unit):
                continue
            for pin in all_of(body, "pin"):
                px, py, _ = numbers(one_of(pin, "at"))
                dx, dy = _turned(px, py, int(angle))
                place = round(x + dx, 3), round(y + dy, 3)
                if property_of(symbol, "Value") == FLAG:
                    continue
                if any(all_of(shape, "power")):
                    names.append((place, property_of(symbol, "Value")))
                else:
                    places[f"{property_of(symbol, 'Reference')}.{one_of(pin, 'number')[1]}"] = place
    for label in all_of(sheet, "label"):
        names.append((_point(one_of(label, "at")), label[1]))
    wires = [
        (_point(a), _point(b))
        for a, b in (all_of(one_of(wire, "pts"), "xy") for wire in all_of(sheet, "wire"))
    ]
    junctions = [_point(one_of(j, "at")) for j in all_of(sheet, "junction")]
    group: dict[Point, Point] = {}

    def root(point: Point) -> Point:
        while group.setdefault(point, point) != point:
            point = group[point]
        return point

    for a, b in wires:
        group[root(a)] = root(b)
        for point in [*junctions, *(p for p, _ in names)]:
            if _is_within(point, (a, b)):
                group[root(point)] = root(a)
    by_name: dict[str, Point] = {}
    for place, name in names:
        group[root(place)] = root(by_name.setdefault(name, place))
    named = {root(place): name for name, place in by_name.items()}
    return {pin: named.get(root(place), "") for pin, place in places.items()}


def _point(element: list[Element]) -> Point:
    x, y = numbers(element)[:2]
    return round(x, 3), round(y, 3)
