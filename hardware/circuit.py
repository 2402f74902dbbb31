"""Table of the parts and nets of both boards.

The SPICE netlist, the KiCad files, the bill of materials and the tables of the build page are made
from :func:`parts` (amplifier for two fingertips and a Teensy 4.0) and :func:`fingertip_parts`. Each
value names its source, or is marked as an assumption.
"""

from __future__ import annotations

import runpy
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

FINGERS = ("index", "thumb")
ROWS, COLUMNS = 3, 2
#: Resistors that the twin has, too. KiCad's Python cannot import the package, but runs one file.
SHARED = runpy.run_path(str(Path(__file__).resolve().parents[1] / "src/firstcontact/core/board.py"))
#: Pins of the Teensy 4.0 by net, as ``firmware/teensy/firstcontact/pins.h`` assigns them.
TEENSY = {
    "14": "adc_index", "15": "adc_thumb",
    "16": "index_column_0", "17": "index_column_1",
    "18": "thumb_column_0", "19": "thumb_column_1",
    "2": "index_row_0", "3": "index_row_1", "4": "index_row_2",
    "5": "thumb_row_0", "6": "thumb_row_1", "7": "thumb_row_2",
    "8": "strip_index", "9": "strip_thumb",
    "3V3": "3v3", "GND": "gnd",
}  # fmt: skip
#: Wires of a fingertip's cable, in the order of the connector's pins. The disc lies between two
#: grounds. The strip changes by 3.3 V at the very contact, so it lies farthest from the disc.
CABLE = ("column_1", "column_0", "gnd", "disc", "gnd", "row_2", "row_1", "row_0", "strip")
#: Numbers of the distributor LCSC by manufacturer's number, where public lists of parts agree.
LCSC = {"BAV199,215": "C40919"}
PAPER = "paper"
ASSUMED = "assumption"


class Kind(StrEnum):
    """Kind of a part, with its name in the bill of materials as value."""

    RESISTOR = "resistor"
    CAPACITOR = "capacitor"
    DIODES = "pair of diodes in series"
    AMPLIFIER = "operational amplifier, four in one case"
    CONNECTOR = "connector"
    BOARD = "microcontroller board"
    TEST_POINT = "test point"
    TAXEL = "taxel: two combs under Velostat"
    DISC = "piezo disc"
    PADS = "pads for wires"


#: KiCad footprint by kind. Those of the library "firstcontact" are drawn by ``write_boards.py``.
FOOTPRINTS = {
    Kind.RESISTOR: "Resistor_SMD:R_0805_2012Metric",
    Kind.CAPACITOR: "Capacitor_SMD:C_0805_2012Metric",
    Kind.DIODES: "Package_TO_SOT_SMD:SOT-23",
    Kind.AMPLIFIER: "Package_SO:SOIC-14_3.9x8.7mm_P1.27mm",
    Kind.CONNECTOR: "Connector_JST:JST_XH_S9B-XH-A_1x09_P2.50mm_Horizontal",
    Kind.BOARD: "firstcontact:Teensy_4.0_sockets",
    Kind.TEST_POINT: "TestPoint:TestPoint_THTPad_D2.0mm_Drill1.0mm",
    Kind.TAXEL: "firstcontact:taxel",
    Kind.DISC: "firstcontact:disc_10mm",
    Kind.PADS: "firstcontact:wires_{}",
}
#: What is ordered besides the parts on the boards: number or description, quantity, purpose.
ACCESSORIES = (
    ("PPTC141LFBN-RC", 2, "socket of 14 contacts for the Teensy"),
    ("XHP-9", 2, "housing for the plug of a cable"),
    ("SXH-001T-P0.6", 18, "crimp contact for the plug of a cable"),
    ("wire, AWG 28, stranded", 18, "cables from the fingertips, up to 0.3 m"),
    ("pin header 1 × 14, 2.54 mm", 2, "pins of the Teensy, if it has none"),
    ("PZT-5A disc, 10 mm across, 0.2 mm thick", 2, "vibration sensor; one or two to spare"),
    ("Velostat (Linqstat), 0.1 mm", 1, "force-sensitive sheet, 10 cm are enough"),
    ("heat-set insert M2, 3 mm long, 3.5 mm wide", 8, "threads of the mounts"),
    ("screw M2", 8, "mounts to the fingers; length in the table of prints"),
    ("silicones, microscope slide", 1, "as Pour and Glue name them"),
    ("copper foil, 35 µm, with conductive adhesive", 1, "contacts of the discs; contact strips"),
)


@dataclass(frozen=True)
class Part:
    """Part of a board, with the net of each of its pins."""

    reference: str
    kind: Kind
    pins: dict[str, str]
    """Net of each pin."""
    purpose: str
    value: float = 0.0
    """Resistance in ohm or capacitance in farad."""
    tolerance: float = 0.0
    """Largest relative deviation of the value."""
    number: str = ""
    """Manufacturer's number."""
    source: str = ASSUMED

    @property
    def lcsc(self) -> str:
        """Number at the distributor LCSC, from which JLCPCB takes parts; "" without one."""
        return LCSC.get(self.number, "")

    @property
    def label(self) -> str:
        """Value as drawings print it, such as ``33k`` or ``33n``."""
        if self.kind in (Kind.TEST_POINT, Kind.PADS):
            return next(iter(self.pins.values())) if len(self.pins) == 1 else "cable"
        if self.kind not in (Kind.RESISTOR, Kind.CAPACITOR):
            return self.number.split(",")[0] or self.kind.split(":")[0]
        for unit, factor in (("k", 1e3), ("", 1.0), ("u", 1e-6), ("n", 1e-9)):
            if self.value >= factor * 0.9999:
                return f"{self.value / factor:.3g}{unit}"
        raise ValueError(f"{self.reference} has the value {self.value}")

    @property
    def footprint(self) -> str:
        """KiCad footprint as "library:name"."""
        return FOOTPRINTS[self.kind].format(len(self.pins))


def _resistor(reference: str, a: str, b: str, value: float, code: str, purpose: str) -> Part:
    number = f"RC0805FR-07{code}L"  # Yageo, 1 %
    return Part(reference, Kind.RESISTOR, {"1": a, "2": b}, purpose, value, 0.01, number)


def _capacitor(
    reference: str, a: str, b: str, value: float, tolerance: float, number: str, purpose: str
) -> Part:
    return Part(reference, Kind.CAPACITOR, {"1": a, "2": b}, purpose, value, tolerance, number)


def _wire(wire: str, finger: str) -> str:
    """Return the net on the amplifier board of a wire in a finger's cable."""
    if wire == "gnd":
        return wire
    if wire in ("disc", "strip"):
        return f"{'pad' if wire == 'strip' else wire}_{finger}"
    return f"{finger}_{wire.replace('row', 'line')}"


def _finger(place: int, finger: str) -> list[Part]:
    """Return the parts of one finger on the amplifier board.

    Their references begin at 10 times ``place``, those of the rows at 20 more.
    """
    n = 10 * place
    disc, clamp, inverting, out = (f"{net}_{finger}" for net in ("disc", "clamp", "fb", "out"))
    parts = [
        _resistor(f"R{n}", disc, "vref", 470e3, "470K", "high pass with the disc: 57 Hz"),
        _resistor(f"R{n + 1}", disc, clamp, 10e3, "10K", "limits the current of a knock"),
        Part(
            f"D{n}", Kind.DIODES, {"1": "gnd", "2": "3v3", "3": clamp},
            "clamps the input to both supply rails", number="BAV199,215",
        ),
        _resistor(f"R{n + 2}", clamp, f"in_{finger}", 10e3, "10K", "protects the amplifier"),
        _resistor(f"R{n + 3}", out, inverting, 33e3, "33K", "gain of 7.5"),
        _resistor(f"R{n + 4}", inverting, "vref", 5.1e3, "5K1", "gain of 7.5"),
        _resistor(f"R{n + 5}", out, f"adc_{finger}", 2.7e3, "2K7", "low pass: 1.8 kHz"),
        _capacitor(
            f"C{n}", f"adc_{finger}", "gnd", 33e-9, 0.05, "C0805C333J5GACTU", "low pass: 1.8 kHz"
        ),
        _resistor(f"R{n + 6}", f"pad_{finger}", f"strip_{finger}", 1e3, "1K", "protects the pin"),
        Part(
            f"J{place}", Kind.CONNECTOR,
            {str(pin): _wire(wire, finger) for pin, wire in enumerate(CABLE, 1)},
            f"cable to the {finger} fingertip", number="S9B-XH-A(LF)(SN)",
        ),
    ]  # fmt: skip
    parts += [
        _resistor(
            f"R{n + 7 + c}", f"{finger}_column_{c}", "gnd", SHARED["DIVIDER_OHM"], "22K",
            f"divider of column {c}",
        )
        for c in range(COLUMNS)
    ]  # fmt: skip
    return parts + [
        _resistor(
            f"R{n + 20 + r}", f"{finger}_line_{r}", f"{finger}_row_{r}",
            SHARED["ROW_OHM"], "330R",
            f"protects the pins of row {r}",
        )
        for r in range(ROWS)
    ]  # fmt: skip


def parts() -> tuple[Part, ...]:
    """Return all parts of the amplifier board."""
    shared = [
        Part(
            "U1", Kind.AMPLIFIER,
            {
                "1": "out_index", "2": "fb_index", "3": "in_index", "4": "3v3",
                "5": "in_thumb", "6": "fb_thumb", "7": "out_thumb",
                "8": "vref", "9": "vref", "10": "half",
                "11": "gnd", "12": "half", "13": "unused", "14": "unused",
            },
            "amplifies both discs and buffers 1.65 V", number="MCP6024-I/SL",
        ),
        _resistor("R1", "3v3", "half", 10e3, "10K", "half of the supply"),
        _resistor("R2", "half", "gnd", 10e3, "10K", "half of the supply"),
        _capacitor("C1", "half", "gnd", 10e-6, 0.2, "GRM21BR61C106KE15L", "steadies 1.65 V"),
        _capacitor("C2", "3v3", "gnd", 100e-9, 0.1, "C0805C104K5RACTU", "supply of U1"),
        Part("A1", Kind.BOARD, dict(TEENSY), "converts and sends", 0, 0, "Teensy 4.0", PAPER),
        *(
            Part(f"TP{n}", Kind.TEST_POINT, {"1": net}, "for a multimeter")
            for n, net in enumerate(("3v3", "vref", "gnd"), 1)
        ),
    ]  # fmt: skip
    return (*shared, *_finger(1, "index"), *_finger(2, "thumb"))


def fingertip_parts() -> tuple[Part, ...]:
    """Return all parts of the fingertip's board. A taxel's number is 2 * row + column."""
    return (
        Part(
            "J1", Kind.PADS, {str(pin): wire for pin, wire in enumerate(CABLE, 1)},
            "cable to the amplifier board",
        ),
        Part("E1", Kind.PADS, {"1": "strip"}, "wire of the contact strip"),
        Part(
            "BZ1", Kind.DISC, {"1": "disc", "2": "gnd"},
            "vibration: wire of the outer face, land under the inner face", source=PAPER,
        ),
        *(
            Part(
                f"T{COLUMNS * row + column}", Kind.TAXEL,
                {"1": f"row_{row}", "2": f"column_{column}"},
                f"force in row {row} and column {column}", source=PAPER,
            )
            for row in range(ROWS)
            for column in range(COLUMNS)
        ),
    )  # fmt: skip
