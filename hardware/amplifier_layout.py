"""Board of the amplifier: Teensy on top, amplifier below it, connectors on the lower edge.

The index finger's amplifier mirrors the thumb's about the middle of U1. Analog signals stay between
the connectors and the Teensy's analog pins. Rows and strips, which switch by 3.3 V, go round them:
those of the index finger along the upper and left edge, those of the thumb on the right.
"""

from __future__ import annotations

from circuit import CABLE
from layout import BACK, FRONT, REVISION, Layout, Point, Step, Text, Track

VIA = Step.VIA
WIDTH, HEIGHT = 65.0, 60.5
#: Middle of U1, about which the amplifiers of both fingers are mirrored.
AXIS = 30.0
#: Middle of the Teensy. Its USB socket is at the right edge.
TEENSY_AT = (46.22, 15.12)
#: Upper edge of the connectors' contacts, and height of the bus of 1.65 V.
CONTACTS, BUS = 51.0, 43.6
POWER = 0.5  # mm, width of the 3.3 V track

_BOTH = {
    # Part of the index finger, part of the thumb: place, angle of each.
    ("R10", "R20"): (17.9, 42.3, 90, 90),
    ("R11", "R21"): (15.9, 42.3, 90, 90),
    ("D10", "D20"): (19.7, 34.6, 270, 270),
    ("R12", "R22"): (23.5, 36.0, 0, 180),
    ("R13", "R23"): (25.2, 41.5, 270, 270),
    ("R14", "R24"): (27.6, 41.5, 270, 270),
}
PLACES = {
    **{
        name: (x if number == 0 else 2 * AXIS - x, y, angles[number])
        for names, (x, y, *angles) in _BOTH.items()
        for number, name in enumerate(names)
    },
    "U1": (AXIS, 36.0, 90),
    "C2": (AXIS, 41.7, 270),
    "R1": (28.73, 30.3, 270), "C1": (31.27, 30.3, 90), "R2": (33.7, 30.3, 90),
    "A1": (*TEENSY_AT, 0),
    "J1": (9.4, CONTACTS, 0), "J2": (35.6, CONTACTS, 0),
    # Beside the Teensy's analog pins 14 to 19, at their pitch.
    "R15": (32.25, 25.8, 90), "R25": (34.79, 25.8, 90),
    "C10": (32.25, 19.9, 90), "C20": (34.79, 19.9, 90),
    "R17": (37.33, 19.9, 90), "R18": (39.87, 19.9, 90),
    "R27": (42.41, 19.9, 90), "R28": (44.95, 19.9, 90),
    "R16": (9.2, 12.0, 90), "R26": (55.6, 36.0, 90),
    # Above the Teensy's pins 2 to 4, and on the way from its pins 5 to 7 to the connector.
    "R30": (55.11, 4.4, 270), "R31": (52.57, 4.4, 270), "R32": (50.03, 4.4, 270),
    "R40": (51.3, 34.25, 90), "R41": (48.76, 34.25, 90), "R42": (46.22, 34.25, 90),
    "TP1": (17.0, 28.4, 0), "TP2": (21.6, 40.2, 0), "TP3": (14.0, 28.4, 0),
}  # fmt: skip


def _mirrored(track: Track, thumb: str) -> Track:
    """Return the thumb's track, mirrored from one of the index finger.

    ``thumb`` names the pads on it in order, such as "R20.1 C21.2".
    """
    pads = iter(thumb.split())
    stops = tuple(
        next(pads) if isinstance(stop, str)
        else (None if stop[0] is None else 2 * AXIS - stop[0], stop[1]) if isinstance(stop, tuple)
        else stop
        for stop in track.stops
    )  # fmt: skip
    return Track(stops, track.side, track.width, track.net)


def _amplifiers() -> list[Track]:
    """Return the tracks of both amplifiers."""
    both = (
        (Track(("R11.1", "R10.1")), "R21.1 R20.1"),
        (Track(("J1.4", (16.9, 43.21))), "J2.4"),
        (Track(("R11.2", (None, 36.0), "R12.1")), "R21.2 R22.1"),
        (Track(("D10.3", (None, 36.0))), "D20.3"),
        (Track(("R12.2", (28.73, 36.0), "U1.3")), "R22.2 U1.5"),
        (Track(("U1.1", "R13.1")), "U1.7 R23.1"),
        (Track(("U1.2", "R14.1", "R13.2")), "U1.6 R24.1 R23.2"),
    )
    return [
        *(track for track, _ in both),
        *(_mirrored(track, thumb) for track, thumb in both),
        # Outputs cross the inputs on the back, to the low pass beside the Teensy's pins.
        Track(("R13.1", (23.9, 40.59), VIA, (23.9, 26.71), (31.0, 26.71), VIA, "R15.1")),
        Track(("R23.1", (36.1, 40.59), VIA, (36.1, 26.71), VIA, "R25.1")),
        Track(("R15.2", "A1.14", "C10.1")),
        Track(("R25.2", "A1.15", "C20.1")),
    ]


def _references() -> list[Track]:
    """Return the tracks of the 1.65 V reference, of its divider and of the supply."""
    return [
        Track(("R1.2", (None, 32.0), "U1.12")),
        Track(("R1.2", "C1.1", "R2.1")),
        Track(("C1.1", "U1.10")),
        Track(("U1.13", "U1.14")),
        Track(("U1.8", "U1.9")),
        Track(("U1.9", (None, 35.1), (30.635, 35.1), (30.635, 39.6), (31.15, 40.115),
               (31.15, BUS))),
        Track(("R10.2", (18.8, 41.39), (21.01, BUS), (38.99, BUS), "R20.2"), width=0.3),
        *(Track((pad, (None, BUS)), width=0.3) for pad in ("R14.2", "R24.2", "TP2.1")),
        # 3.3 V runs above both amplifiers, below the rows of the thumb, and below U1 to its pin.
        Track(("A1.3V3", (None, 28.4), (55.6, 28.4), VIA, (44.8, 28.4), VIA, "TP1.1"), width=POWER),
        *(
            Track(((x, 28.4), pad), width=POWER, net="3v3")
            for x, pad in ((18.75, "D10.2"), (39.35, "D20.2"), (28.73, "R1.1"))
        ),
        Track(
            ((26.9, 28.4), VIA, (26.9, 38.65), (28.95, 40.7), VIA, "C2.1"), width=POWER, net="3v3"
        ),
        Track(("C2.1", "U1.4"), width=POWER),
    ]  # fmt: skip


def _digital() -> list[Track]:
    """Return the tracks of the force arrays' rows and columns, and of the contact strips."""
    below = CONTACTS + 2.2
    return [
        # Rows of the index finger: above the Teensy, down the left edge, below the connector.
        *(
            Track((f"R{32 - n}.1", (None, 2.4 - 0.6 * n), (7.3 - 0.6 * n, None),
                   (None, below + 0.6 * n), (pad, None), f"J1.{6 + n}"))
            for n, pad in enumerate((21.9, 24.4, 26.9))
        ),
        *(Track((f"A1.{4 - n}", f"R{32 - n}.2")) for n in range(3)),
        Track(("A1.8", (None, 5.6), (9.2, None), "R16.2")),
        Track(("R16.1", (9.2, 13.6), (8.0, 14.8), (8.0, 44.0), VIA, (8.0, below + 2.4),
               (29.4, None), "J1.9")),
        # Rows of the thumb: below the Teensy and straight down.
        *(
            Track((f"A1.{5 + r}", (None, 11.0), (51.3 - 2.54 * r, 14.81), f"R{40 + r}.2"))
            for r in range(3)
        ),
        *(
            Track((f"R{40 + r}.1", (51.3 - 2.54 * r, 46.0), f"J2.{8 - r}")) for r in range(3)
        ),
        Track(("A1.9", (None, 12.6), (53.84, None), VIA, (53.84, 32.0), "R26.2"), BACK),
        Track(("R26.1", "J2.9")),
        # Columns: those of the index finger left of its amplifier, those of the thumb on the back.
        Track(("J1.2", (None, 17.2), (36.06, None), (None, 21.4), "A1.16")),
        Track(("J1.1", (None, 16.6), (38.6, None), (None, 21.4), "A1.17")),
        *(Track((f"R{n}.1", f"A1.{pin}")) for n, pin in ((17, 16), (18, 17), (27, 18), (28, 19))),
        Track(("J2.1", (37.2, 48.3), (37.2, 32.0), (41.14, 28.06), (41.14, 21.2), (43.2, 21.2),
               "A1.19"), BACK),
        Track(("J2.2", (37.9, 48.3), (37.9, 32.3), (42.41, 27.79), "A1.18"), BACK),
    ]  # fmt: skip


def _texts() -> list[Text]:
    """Return the texts on the silkscreen, without the names of parts."""
    words = [wire.replace("column", "col").replace("_", " ") for wire in CABLE]
    return [
        *(
            Text(word, (PLACES[name][0] + 2.5 * n, CONTACTS - 2.7), 0.8, 90, align=-1)
            for name in ("J1", "J2")
            for n, word in enumerate(words)
        ),
        Text("firstcontact", (12.0, 8.6), 1.4, align=-1),
        Text(f"amplifier, rev {REVISION}", (12.0, 10.8), align=-1),
        Text("two fingertips", (12.0, 12.6), align=-1),
        Text("CERN-OHL-P-2.0", (12.0, 14.4), align=-1),
        Text("J1 INDEX", (14.2, 38.0), 1.2),
        Text("J2 THUMB", (57.6, 41.0), 1.2),
        Text("3V3", (17.0, 30.6), 0.8),
        Text("GND", (14.0, 30.6), 0.8),
        Text("1.65V", (21.6, 38.2), 0.8),
        Text("TEENSY 4.0", (44.0, 12.6), 1.2),
        Text("USB", (61.6, 15.1), 1.0, 90),
    ]


#: Vias of the ground beside pads, and between the rows of the thumb.
_VIAS: tuple[Point, ...] = (
    (20.65, 32.2), (41.25, 32.2), (29.8, 35.2), (32.48, 29.39), (28.95, 42.6),
    (33.52, 18.99), (37.33, 17.95), (41.14, 18.99), (43.68, 18.99),
    *((x, y) for x in (47.49, 50.03) for y in (26.0, 31.5, 37.0, 42.5)),
)  # fmt: skip
#: Names of parts on the silkscreen, relative to their middle. A1, J1, J2 and TP have words.
_NAMES = {
    "U1": (-5.6, -2.6), "C2": (0.0, 2.3),
    "R1": (0.0, -2.1), "C1": (0.0, -2.1), "R2": (0.0, -2.1),
    "R10": (1.95, 0.0), "R20": (-1.95, 0.0), "R11": (-1.95, 0.0), "R21": (1.95, 0.0),
    "D10": (-2.9, 0.0), "D20": (2.9, 0.0), "R12": (0.0, -1.5), "R22": (0.0, -1.5),
    "R13": (0.0, 2.5), "R23": (0.0, 2.5), "R14": (0.0, 2.5), "R24": (0.0, 2.5),
    "R15": (-2.0, -0.3), "R25": (2.0, -0.6), "R16": (0.0, -2.4), "R26": (2.1, 0.0),
    **dict.fromkeys(("C10", "C20", "R17", "R18", "R27", "R28"), (0.0, -3.0)),
    **dict.fromkeys(("R30", "R31", "R32"), (0.0, -3.0)),
    **dict.fromkeys(("R40", "R41", "R42"), (0.0, 2.6)),
}  # fmt: skip

AMPLIFIER = Layout(
    name="amplifier",
    title="firstcontact amplifier",
    corner=(0, 0),
    size=(WIDTH, HEIGHT),
    places=PLACES,
    tracks=(*_amplifiers(), *_references(), *_digital()),
    grounded=(FRONT, BACK),
    holes=tuple((x, y) for y in (3.3, HEIGHT - 3.3) for x in (3.3, WIDTH - 3.3)),
    texts=tuple(_texts()),
    vias=_VIAS,
    stitching=5.0,
    names=_NAMES,
)
