"""Tables of labels and channels for BioTac recordings in MATLAB files.

    python examples/biotac_tables.py FOLDER labels.csv channels.csv
    firstcontact import FOLDER --labels labels.csv --channels channels.csv --source real --out held

Each file, OBJECT_NUMBER_TRIAL_HOLD.mat, holds the signals of two fingertips while a gripper holds
an object. Vibration is sampled at 2200 Hz and stored in packets of 22 samples. The other signals
are sampled at 100 Hz. Each trial becomes a session. The name of an object gives its hardness class.
"""

from __future__ import annotations

import csv
import sys
from pathlib import Path

HARD = ("acrylic", "steel_vase")


def rows(path: Path, lines: list[list[str]]) -> None:
    """Write a CSV file with one row per line."""
    with path.open("w", encoding="utf-8", newline="") as table:
        csv.writer(table).writerows(lines)


def main(folder: Path, labels: Path, channels: Path) -> None:
    """Write one table with each file's object, and one with each variable's sensor."""
    lines = [["file", "object", "specimen", "session", "hardness_class"]]
    for file in sorted(folder.glob("*_HOLD.mat")):
        *words, _, trial, _ = file.stem.split("_")
        name = "_".join(words)
        hard = "hard" if name in HARD else "soft"
        lines.append([file.name, name.replace("_", " "), name, trial, hard])
    rows(labels, lines)
    lines = [["variable", "sensor", "finger", "rate_hz", "offset", "column"]]
    for finger, mark in (("index", "F0"), ("thumb", "F1")):
        # Values are 12-bit steps around the middle. The files do not contain the maker's scale.
        lines.append([f"{mark}pac", "hydrophone", finger, "2200", "2048", "all"])
        for signal in ("pdc", "tac", "tdc", "Electrodes"):
            lines.append([f"{mark}{signal}", "", finger, "100", "", ""])
    rows(channels, lines)


if len(sys.argv) == 4:
    main(*map(Path, sys.argv[1:]))
else:
    print("give the folder of recordings, and the names of the two tables to write")
