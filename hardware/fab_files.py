"""Files to order boards: ZIP files of Gerbers, and lists of parts and positions.

Each run writes the same bytes, so that ``hardware/fab`` changes only with the boards.
"""

from __future__ import annotations

import csv
import re
import zipfile
from collections.abc import Iterable, Sequence
from pathlib import Path

from amplifier_layout import HEIGHT
from boards import FOLDER, SMD, read_board
from circuit import ACCESSORIES, Kind, Part, parts

FAB = FOLDER.parent / "fab"
#: Place of the board's upper left corner on KiCad's sheet, mm.
SHEET = (100.0, 70.0)
#: Lines of Gerber and drill files that name a date.
DATED = re.compile(
    r"^(%TF\.CreationDate|G04 Created by|; DRILL file|; #@! TF\.CreationDate).*\n", re.M
)
MAKERS = {
    "RC0805": "Yageo", "C0805": "KEMET", "GRM": "Murata", "BAV199": "Nexperia",
    "MCP": "Microchip", "S9B": "JST", "Teensy": "PJRC",
}  # fmt: skip
#: Columns of each assembly house, by list.
HOUSES = {
    "jlcpcb": {
        "bom": ("Comment", "Designator", "Footprint", "JLCPCB Part #", "Manufacturer Part"),
        "positions": ("Designator", "Mid X", "Mid Y", "Layer", "Rotation"),
    },
    "pcbway": {
        "bom": (
            "Item #", "Designator", "Qty", "Manufacturer", "Mfg Part #", "Description / Value",
            "Package/Footprint", "Type",
        ),
        "positions": ("Designator", "Mid X", "Mid Y", "Layer", "Rotation"),
    },
}  # fmt: skip
Row = tuple[str, ...]


def maker(number: str) -> str:
    """Return the name of a part's maker, given the maker's part number."""
    return next((name for start, name in MAKERS.items() if number.startswith(start)), "")


def _groups() -> list[list[Part]]:
    """Return the parts that a machine places, in one group per part number."""
    groups: dict[str, list[Part]] = {}
    for part in parts():
        if part.kind in SMD:
            groups.setdefault(part.number, []).append(part)
    return list(groups.values())


def bom(house: str) -> list[Row]:
    """Return the rows of the bill of materials for an assembly house: parts placed by machine."""
    rows = []
    for item, group in enumerate(_groups(), 1):
        first, names = group[0], ",".join(part.reference for part in group)
        shape, number = first.footprint.split(":")[1], first.number
        if house == "jlcpcb":
            rows.append((first.label, names, shape, first.lcsc, number))
        else:
            is_valued = first.kind in (Kind.RESISTOR, Kind.CAPACITOR)
            words = f"{first.label} {100 * first.tolerance:g} %" if is_valued else str(first.kind)
            rows.append(
                (str(item), names, str(len(group)), maker(number), number, words, shape, "SMD")
            )
    return [HOUSES[house]["bom"], *rows]


def positions(house: str) -> list[Row]:
    """Return the rows of part positions for an assembly house, mm from the lower left corner.

    Angles are KiCad's. Houses turn some cases otherwise: their preview shows it.
    """
    placed = read_board(FOLDER / "amplifier/amplifier.kicad_pcb")
    rows = []
    for part in (part for group in _groups() for part in group):
        x, y, angle = placed[part.reference].at
        place = f"{x - SHEET[0]:.4f}mm", f"{HEIGHT - (y - SHEET[1]):.4f}mm"
        rows.append((part.reference, *place, "Top", f"{angle % 360:g}"))
    return [HOUSES[house]["positions"], *rows]


def accessories() -> list[Row]:
    """Return the rows of all else to order: parts soldered by hand, cables and the like."""
    by_hand: dict[str, list[Part]] = {}
    for part in parts():
        if part.number and part.kind not in SMD:
            by_hand.setdefault(part.number, []).append(part)
    return [
        ("what", "quantity", "purpose"),
        *(
            (number, str(len(group)), f"{group[0].kind} {' '.join(p.reference for p in group)}")
            for number, group in by_hand.items()
        ),
        *((name, str(count), purpose) for name, count, purpose in ACCESSORIES),
    ]


def write_csv(file: Path, rows: Iterable[Row]) -> None:
    """Write rows into a CSV file."""
    with file.open("w", encoding="utf-8", newline="") as stream:
        csv.writer(stream, lineterminator="\n").writerows(rows)


def write_lists(folder: Path = FAB) -> None:
    """Write the lists for all assembly houses, and the list of accessories."""
    folder.mkdir(parents=True, exist_ok=True)
    for house in HOUSES:
        write_csv(folder / f"amplifier-bom-{house}.csv", bom(house))
        write_csv(folder / f"amplifier-positions-{house}.csv", positions(house))
    write_csv(folder / "accessories.csv", accessories())


def write_zip(file: Path, members: Sequence[Path]) -> None:
    """Write Gerber and drill files into a ZIP file, without their dates."""
    file.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for member in sorted(members):
            entry = zipfile.ZipInfo(member.name)  # of 1980
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, DATED.sub("", member.read_text("utf-8")))
