"""KiCad footprints of this project: Teensy sockets, taxel, land of the disc, wire pads."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from fingertip_layout import (
    DISC_WIRE,
    DISC_WIRE_SIDE,
    FINGER,
    FINGERS,
    GAP,
    LAND,
    OPENING,
    OVERLAP,
    WIRE_PAD,
    WIRES_PITCH,
    comb,
)
from layout import Point
from sexpr import Element, Word, write

#: Names of the Teensy's pins from its USB socket on: the row of digital pins, then the other.
TEENSY_ROWS = (
    ("GND", *(str(n) for n in range(13))),
    ("VIN", "GND", "3V3", *(str(n) for n in range(23, 12, -1))),
)
NOT_PLACED = ("smd", "exclude_from_pos_files", "exclude_from_bom")
BACK_PAD = ("B.Cu", "B.Mask")


def _word(name: str, *rest: Element) -> list[Element]:
    return [Word(name), *rest]


def _xy(name: str, point: Sequence[float]) -> list[Element]:
    return _word(name, *(round(float(value), 4) for value in point))


def _footprint(name: str, attributes: Sequence[str], *parts: Element, side: str = "F") -> Element:
    return _word(
        "footprint", name, _word("version", 20241229), _word("generator", "firstcontact"),
        _word("layer", f"{side}.Cu"), _word("attr", *map(Word, attributes)), *parts,
    )  # fmt: skip


def _pad(
    number: str,
    kind: str,
    shape: str,
    at: Point,
    size: Point,
    layers: Sequence[str],
    *more: Element,
) -> Element:  # fmt: skip
    return _word(
        "pad", number, Word(kind), Word(shape), _xy("at", at), _xy("size", size),
        _word("layers", *layers), *more,
    )  # fmt: skip


def _draw(shape: str, start: Point, end: Point, layer: str, width: float = 0.12) -> Element:
    stroke = _word("stroke", _word("width", width), _word("type", Word("solid")))
    fill = [_word("fill", Word("no"))] if shape == "fp_rect" else []
    ends = _xy("start", start), _xy("end", end)
    return _word(shape, *ends, stroke, *fill, _word("layer", layer))


def _teensy() -> Element:
    """Return the footprint of the Teensy's two sockets, which have 14 contacts each.

    They are 15.24 mm apart. The USB socket is to the right.
    """
    x, y = 17.78, 8.89
    pads = [
        _pad(
            name, "thru_hole", "rect" if name == "VIN" else "circle",
            (16.51 - 2.54 * place, row), (1.7, 1.7), ("*.Cu", "*.Mask"), _word("drill", 1.0),
        )
        for row, names in zip((-7.62, 7.62), TEENSY_ROWS, strict=True)
        for place, name in enumerate(names)
    ]  # fmt: skip
    return _footprint(
        "Teensy_4.0_sockets", ("through_hole",), *pads,
        _draw("fp_rect", (-x, -y), (x, y), "F.Fab", 0.1),
        # Low parts may stand between the sockets.
        *(
            _draw("fp_rect", (-x, row - 1.1), (x - 0.05, row + 1.1), "F.CrtYd", 0.05)
            for row in (-7.62, 7.62)
        ),
        *(_draw("fp_line", (-x, s), (x - 0.3, s), "F.SilkS") for s in (-y, y)),
        _draw("fp_line", (-x, -y), (-x, y), "F.SilkS"),
        _draw("fp_rect", (12.2, -3.7), (x - 0.3, 3.7), "F.SilkS"),
    )  # fmt: skip


def _taxel() -> Element:
    """Return the footprint of a taxel: two combs, and the opening of the solder mask over them."""
    pads = []
    for number, kind in (("1", "row"), ("2", "column")):
        outline = comb(kind)
        anchor = (0.0, (outline[0][1] + outline[1][1]) / 2)  # within the spine
        points = [_xy("xy", (x - anchor[0], y - anchor[1])) for x, y in outline]
        polygon = _word(
            "gr_poly", _word("pts", *points), _word("width", 0), _word("fill", Word("yes"))
        )
        options = _word(
            "options", _word("clearance", Word("outline")), _word("anchor", Word("circle"))
        )
        pads.append(
            _pad(number, "smd", "custom", anchor, (0.25, 0.25), ("F.Cu",), options,
                 _word("primitives", polygon))
        )  # fmt: skip
    half = (FINGERS * (FINGER + GAP) - GAP) / 2 + OPENING
    opening = _draw(
        "fp_rect", (-half, -OVERLAP - OPENING), (half, OVERLAP + OPENING), "F.Mask", 0.0
    )
    opening[4] = _word("fill", Word("yes"))
    return _footprint("taxel", (*NOT_PLACED, "allow_soldermask_bridges"), *pads, opening)


def _disc() -> Element:
    """Return the footprint of the disc on the back: land of its inner face, and a wire pad."""
    return _footprint(
        "disc_10mm", NOT_PLACED,
        _pad("1", "smd", "circle", DISC_WIRE, (DISC_WIRE_SIDE, DISC_WIRE_SIDE), BACK_PAD),
        _pad("2", "smd", "circle", (0.0, 0.0), (2 * LAND, 2 * LAND), BACK_PAD,
             _word("solder_mask_margin", 0.05), _word("zone_connect", 2)),
        side="B",
    )  # fmt: skip


def _wires(count: int) -> Element:
    """Return the footprint of pads on the back for ``count`` wires. The first one is square."""
    pads = [
        _pad(
            str(n + 1), "smd", "roundrect", (0.0, (n - (count - 1) / 2) * WIRES_PITCH), WIRE_PAD,
            BACK_PAD, _word("roundrect_rratio", 0.25 if n else 0.0),
            # Ground reaches the pads of the cable from one side only: its neck is relief enough.
            _word("zone_connect", 2),
        )
        for n in range(count)
    ]  # fmt: skip
    return _footprint(f"wires_{count}", NOT_PLACED, *pads, side="B")


def write_footprints(folder: Path) -> None:
    """Write all footprints into a folder, which becomes a KiCad library."""
    folder.mkdir(parents=True, exist_ok=True)
    for footprint in (_teensy(), _taxel(), _disc(), _wires(9), _wires(1)):
        file = folder / f"{footprint[1]}.kicad_mod"
        file.write_text(write(footprint) + "\n", "utf-8")
