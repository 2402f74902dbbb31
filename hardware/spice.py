"""Netlists of the amplifier board for ngspice, and a function that simulates them."""

from __future__ import annotations

import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from circuit import COLUMNS, FINGERS, ROWS, Kind, parts
from disc import CAPACITANCE
from numpy.typing import NDArray

from firstcontact.core.board import PIN_OHM
from firstcontact.core.layout import ADC_COUNTS, ADC_VOLTS

#: Step of the Teensy's converter, V.
COUNT = ADC_VOLTS / (ADC_COUNTS - 1)
#: Converter of the i.MX RT1062 (data sheet): capacitance of its sample, F, and resistance of its
#: switch, ohm. It samples for 2 us as Teensyduino sets it. The cable and the pin have 60 pF more.
SAMPLE_FARAD, SWITCH_OHM, SAMPLE_TIME, CABLE_FARAD = 2e-12, 6e3, 2e-6, 60e-12
#: One amplifier of the MCP6024, from its data sheet: offset at most 0.5 mV, gain-bandwidth
#: product 10 MHz, 7 V/us, 8.7 nV/sqrt(Hz), output within 20 mV of the rails. The model is our own:
#: an integrator with limits. 4600 ohm have the noise voltage of the data sheet at 27 degrees.
AMPLIFIER = """
.subckt amplifier plus minus out vdd vss offset=0
Voff plus biased {offset}
Rnoise biased quiet 4600
Rleak quiet vss 1e13
Ggm vss stage quiet minus 20.94e-6
Cgm stage vss 1p
Rgm stage middle 1.6e9
Bhigh stage 0 I=max(0, V(stage)-V(vdd))*1e-4
Blow 0 stage I=max(0, V(vss)-V(stage))*1e-4
Rhalf1 vdd middle 1e6
Rhalf2 middle vss 1e6
Bout drive 0 V=V(middle)+(V(vdd)-V(vss)-0.04)/2*tanh(3*(V(stage)-V(middle)))
Rout drive out 50
.ends
"""
#: BAV199: leakage 3 pA typical at 75 V, at most 5 nA at 75 V and 25 degrees; 2 pF.
#: BAT54S, for comparison: leakage of some 0.3 uA at low voltage (2 uA at 25 V at most).
DIODES = """
.model bav199 D(IS=1e-14 N=1.1 RS=1.5 CJO=2p BV=85 IBV=5n EG=1.11 XTI=3)
.model bat54s D(IS=2e-7 N=1.05 RS=2 CJO=10p BV=30 IBV=2u EG=0.69 XTI=2)
"""


def board(
    *,
    discs: Mapping[str, str] | None = None,
    values: Mapping[str, float] | None = None,
    offsets: Mapping[str, float] | None = None,
    diode: str = "bav199",
    supply: str = "DC 3.3",
    leakage: tuple[float, float] = (1.0, 1.0),
    driven: int | None = None,
    taxel: float = 0.0,
    celsius: float = 27.0,
) -> list[str]:
    """Return the lines of the amplifier board's netlist, with two discs.

    Parameters
    ----------
    discs
        Open-circuit voltage of the disc by finger, as a SPICE source. The default is 0.
    values
        Values that differ from the table, by reference.
    offsets
        Offset voltage of an amplifier by its output net, V.
    diode
        Model of the clamps.
    supply
        SPICE source of the 3.3 V supply.
    leakage
        Factors on the leakage of the diodes to ground and to the supply.
    driven
        Row at 3.3 V. The others are at ground.
    taxel
        Conductance of the taxels in the driven row, S. The others do not conduct.
    celsius
        Temperature.
    """
    lines = [AMPLIFIER, DIODES, f"Vsupply 3v3 0 {supply}"]
    for finger in FINGERS:
        source = (discs or {}).get(finger, "DC 0")
        lines += [
            f"Vdisc_{finger} force_{finger} gnd {source}",
            f"Cdisc_{finger} force_{finger} disc_{finger} {CAPACITANCE}",
            f"Rpull_{finger} 3v3 strip_{finger} 100k",  # within the Teensy
        ]
        for row in range(ROWS):
            lines.append(f"Vrow_{finger}_{row} pin_{finger}_{row} 0 {3.3 * (row == driven)}")
            lines.append(f"Rrow_{finger}_{row} pin_{finger}_{row} {finger}_row_{row} {PIN_OHM}")
        if driven is not None and taxel:
            lines += [
                f"Rtaxel_{finger}_{c} {finger}_line_{driven} {finger}_column_{c} {1 / taxel:.9g}"
                for c in range(COLUMNS)
            ]
    outputs = []
    for part in parts():
        nets = part.pins
        if part.kind in (Kind.RESISTOR, Kind.CAPACITOR):
            value = (values or {}).get(part.reference, part.value)
            lines.append(f"{part.reference} {nets['1']} {nets['2']} {value:.9g}")
        elif part.kind is Kind.DIODES:
            lines.append(f"{part.reference}a {nets['1']} {nets['3']} {diode} area={leakage[0]}")
            lines.append(f"{part.reference}b {nets['3']} {nets['2']} {diode} area={leakage[1]}")
        elif part.kind is Kind.AMPLIFIER:
            for pins in (("3", "2", "1"), ("5", "6", "7"), ("10", "9", "8"), ("12", "13", "14")):
                plus, minus, out = (nets[pin] for pin in pins)
                offset = (offsets or {}).get(out, 0.0)
                terminals = f"{plus} {minus} {out} {nets['4']} {nets['11']}"
                lines.append(f"X_{out} {terminals} amplifier offset={offset:.9g}")
                outputs.append(out)
    # Start values for the search of the operating point.
    nodes = ["half", *outputs, *(f"x_{out}.stage" for out in outputs)]
    nodes += [f"{net}_{f}" for f in FINGERS for net in ("disc", "clamp", "in", "fb", "adc")]
    lines.append(".nodeset v(3v3)=3.3 " + " ".join(f"v({node})=1.65" for node in nodes))
    return [*lines, f".options temp={celsius}"]


def sound_input(input_ohm: float, disc: float) -> list[str]:
    """Return the netlist of a two-euro disc at a sound input (``tutorial/two-euro-disc.md``).

    Parameters
    ----------
    input_ohm
        Resistance of the sound input, ohm.
    disc
        Capacitance of the disc, F.
    """
    return [
        ".model d1n4148 D(IS=2.5n N=1.75 RS=0.6 CJO=4p)",
        "Vdisc force 0 DC 0 AC 1",
        f"Cdisc force disc {disc}",
        "Rload disc 0 1meg",
        "Rseries disc input 10k",
        "D1 input 0 d1n4148",
        "D2 0 input d1n4148",
        f"Rinput input 0 {input_ohm}",
    ]


def sampled_charge(volts: float, column_ohm: float) -> list[str]:
    """Return the netlist of a column at ground whose reading follows one of another pin.

    Parameters
    ----------
    volts
        Voltage that the earlier reading left on the converter, V.
    column_ohm
        Resistance of the column's divider, ohm.
    """
    return [
        f"Rcolumn column 0 {column_ohm}",
        f"Ccable column 0 {CABLE_FARAD} ic=0",
        f"Rswitch column sample {SWITCH_OHM}",
        f"Csample sample 0 {SAMPLE_FARAD} ic={volts}",
    ]


def simulate(netlist: Sequence[str], analysis: str, *vectors: str) -> list[NDArray[np.float64]]:
    """Run one analysis. Return its scale (time or frequency), then each vector.

    Raises
    ------
    RuntimeError
        ngspice failed.
    """
    with tempfile.TemporaryDirectory() as folder:
        commands = [".control", analysis, f"wrdata out {' '.join(vectors)}", ".endc", ".end"]
        options = ".options reltol=1e-4 abstol=1e-12 gmin=1e-13 itl1=500"
        deck = Path(folder, "deck.cir")
        deck.write_text("\n".join(["title", *netlist, options, *commands]) + "\n", "utf-8")
        process = subprocess.run(
            ["ngspice", "-b", str(deck)], cwd=folder, capture_output=True, text=True, check=False
        )
        messages = process.stdout + process.stderr
        # After a failed search for the operating point the charges of capacitors are arbitrary.
        if not Path(folder, "out").exists() or "Transient op" in messages:
            raise RuntimeError(f"ngspice failed:\n{messages[-2000:]}")
        columns = np.loadtxt(Path(folder, "out"), ndmin=2).T
    return [columns[0], *columns[1::2]]
