"""The tables of labels and of channels for BioTac recordings in MATLAB files.

    python examples/biotac_tables.py FOLDER labels.csv channels.csv
    firstcontact import FOLDER --labels labels.csv --channels channels.csv --source real --out held

The files are of a pair of fingertips on a gripper, of the time while it holds an object:
OBJECT_NUMBER_TRIAL_HOLD.mat. Vibration comes at 2200 Hz in packets of 22, everything else at
100 Hz. The trial is the session; hardness is a judgement of the objects by their names.
"""

from __future__ import annotations

import csv
import sys
from pathlib import Path

HARD = ("acrylic", "steel_vase")


def rows(path: Path, lines: list[list[str]]) -> None:
    """Write a table."""
    with path.open("w", encoding="utf-8", newline="") as table:
        csv.writer(table).writerows(lines)


def main(folder: Path, labels: Path, channels: Path) -> None:
    """Name each file's object, and each variable's sensor."""
    lines = [["file", "object", "specimen", "session", "hardness_class"]]
    for file in sorted(folder.glob("*_HOLD.mat")):
        *words, _, trial, _ = file.stem.split("_")
        thing = "_".join(words)
        hard = "hard" if thing in HARD else "soft"
        lines.append([file.name, thing.replace("_", " "), thing, trial, hard])
    rows(labels, lines)
    lines = [["variable", "sensor", "finger", "rate_hz", "offset"]]
    for finger, mark in (("index", "F0"), ("thumb", "F1")):
        # 12 bits around their middle, in steps: the maker's scale is not in the files.
        lines.append([f"{mark}pac", "hydrophone", finger, "2200", "2048"])
        for name in ("pdc", "tac", "tdc", "Electrodes"):
            lines.append([f"{mark}{name}", "", finger, "100", ""])
    rows(channels, lines)


if len(sys.argv) == 4:
    main(*map(Path, sys.argv[1:]))
else:
    print("give the folder of the set, and the two tables to write")
