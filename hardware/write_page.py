"""Write the tables of the build page and of the circuit's page, from parts and simulation.

python hardware/write_page.py            # the tables
python hardware/write_page.py --measure  # simulates the circuit first, with ngspice
"""

from __future__ import annotations

import argparse
import json
import re
from dataclasses import asdict
from pathlib import Path

from circuit import FINGERS, SHARED, TEENSY, Kind, parts
from disc_tables import discs_table, gluings_table
from mount_tables import fit_table, pour_table, print_table
from multimeter_tables import resistors_table
from order_tables import accessories_table, order_table
from simulate import WRONG, Board, check, is_found, measure, twin_response

from firstcontact_lab.report.tables import fill, markdown_table

ROOT = Path(__file__).resolve().parents[1]
BUILD, CIRCUIT = (
    ROOT / "docs" / name for name in ("how-to/build-a-fingertip.md", "reference/fingertip.md")
)
RESULTS = ROOT / "docs/results/circuit.json"


def parts_table() -> str:
    """Return a Markdown table of the amplifier board's parts, to order them."""
    rows: dict[tuple[str, str, str], list[str]] = {}
    purposes: dict[tuple[str, str, str], str] = {}
    for part in parts():
        if part.kind is Kind.TEST_POINT:
            continue
        unit = {Kind.RESISTOR: "Ω", Kind.CAPACITOR: "F"}.get(part.kind, "")
        number, prefix = re.fullmatch(r"([\d.]+)(\D?)", part.label).groups() if unit else ("", "")
        value = f"{number} {prefix}{unit}".replace("u", "µ") if unit else part.kind
        tolerance = f" ± {100 * part.tolerance:g} %" if part.tolerance else ""
        key = value + tolerance, part.number, part.source
        rows.setdefault(key, []).append(part.reference)
        purpose = re.sub(r" to the (index|thumb) fingertip| of (column|row) \d", "", part.purpose)
        previous = purposes.setdefault(key, purpose)
        if purpose not in previous:
            purposes[key] = f"{previous}; {purpose}"
    cells = []
    for (value, number, source), names in rows.items():
        mark = source if source == "paper" else f"**{source}**"
        purpose = purposes[value, number, source]
        cells.append((", ".join(names), value, number, purpose, mark))
    return markdown_table("parts | value | number | what for | from", cells)


def pins_table() -> str:
    """Return a Markdown table of the Teensy's pins and their nets."""
    divider, row = SHARED["DIVIDER_OHM"], SHARED["ROW_OHM"]
    words = {
        f"adc_{f}": (f, "piezo, behind the low pass") for f in FINGERS
    } | {f"strip_{f}": (f, "strip, over 1 kΩ") for f in FINGERS}  # fmt: skip
    for finger in FINGERS:
        words |= {
            f"{finger}_column_{c}": (finger, f"column {c} with its {divider / 1e3:g} kΩ")
            for c in range(2)
        }
        words |= {f"{finger}_row_{r}": (finger, f"row {r}, over {row:g} Ω") for r in range(3)}
    cells = []
    for pin, net in TEENSY.items():
        if net in words:
            analog = f" (A{int(pin) - 14})" if int(pin) >= 14 else ""
            cells.append((f"{pin}{analog}", *words[net]))
    return markdown_table("pin | finger | goes to", cells)


#: Table of the simulated circuit, filled from the fields of ``simulate.Board``.
SIMULATION = """| quantity | simulated | compare |
|---|---|---|
| largest gain | {gain:.1f} | {twin[0]:.1f} in the twin; {gains[0]:.1f} to {gains[1]:.1f} with tolerances |
| lower corner | {low_hz:.0f} Hz | {twin[1]:.0f} Hz in the twin; {lows[0]:.0f} to {lows[1]:.0f} Hz with tolerances |
| upper corner | {high_hz:.0f} Hz | {twin[2]:.0f} Hz in the twin; {highs[0]:.0f} to {highs[1]:.0f} Hz with tolerances |
| noise of the amplifier | {microvolts:.0f} µV | a converter step is 3226 µV |
| offset by leakage of the clamp at 27 and 50 °C | {offset_counts[bav199_27]:.1f} and {offset_counts[bav199_50]:.1f} steps | {offset_counts[bat54s_27]:.0f} and {offset_counts[bat54s_50]:.0f} steps with a BAT54S |
| offset by the amplifier, at most | {amplifier_offset_counts:.1f} steps | its data sheet allows 0.5 mV |
| knock of 40 V, voltage at the Teensy | {pin_volts[0]:.2f} to {pin_volts[1]:.2f} V | −0.3 to 3.6 V are allowed |
| – until the offset is below one step | {recovery_ms:.0f} ms | |
| – at the other finger | {coupling_counts:.2f} steps | |
| 10 mV of 1 kHz on the supply, also the converter's reference | {ripple_counts:.1f} steps peak to peak | below 3 Hz both move alike |
| two connected rows, current through their pins | {milliamperes:.1f} mA | 4 mA are recommended, 72 mA flow without the row's resistors |
| piezo's level in a column's first and second reading | {carry_counts[0]:.1f} and {carry_counts[1]:.2f} steps | the first reading is discarded |
| two-euro disc at 2 kΩ, 10 kΩ and 1 MΩ, lower corner | {sound_hz[2k]:.0f}, {sound_hz[10k]:.0f} and {sound_hz[1000k]:.0f} Hz | [tutorial](../tutorial/two-euro-disc.md) |"""


def simulation_table(board: Board) -> str:
    """Return a Markdown table that compares the simulated circuit with the twin."""
    return SIMULATION.format(
        **asdict(board),
        twin=twin_response(),
        gains=board.tolerance["gain"],
        lows=board.tolerance["low_hz"],
        highs=board.tolerance["high_hz"],
        microvolts=1e6 * board.noise_volts,
        recovery_ms=1e3 * board.recovery_s,
        milliamperes=1e3 * max(board.short_amperes),
    )


def filled(text: str, board: Board) -> str:
    """Return the page ``text`` with its tables replaced."""
    tables = {
        "parts": parts_table(),
        "pins": pins_table(),
        "simulation": simulation_table(board),
        "gluings": gluings_table(),
        "discs": discs_table(),
        "order": order_table(),
        "accessories": accessories_table(),
        "print": print_table(),
        "pour": pour_table(),
        "fit": fit_table(),
        "resistors": resistors_table(),
    }
    return fill(text, "hardware", tables)


def read_results() -> Board:
    """Return the measurements that the last simulation stored."""
    values = json.loads(RESULTS.read_text("utf-8"))
    return Board(**{name: value for name, value in values.items() if name != "command"})


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--measure", action="store_true", help="simulate the circuit first")
    if parser.parse_args().measure:
        board = measure(boards=200, seed=1)
        check(board)
        for reference, factor in WRONG.items():
            if not is_found(board, reference, factor):
                raise SystemExit(f"the check overlooks {reference} with {factor:g} times its value")
        print(f"found as it should be: each of {len(WRONG)} wrong values")
        results = {"command": "python hardware/write_page.py --measure", **asdict(board)}
        RESULTS.write_text(json.dumps(results, indent=1) + "\n", "utf-8")
    for page in (BUILD, CIRCUIT):
        page.write_text(filled(page.read_text("utf-8"), read_results()), "utf-8")
