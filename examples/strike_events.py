"""The table of contacts of a set of struck pads, from the two tables that come with it.

    python examples/strike_events.py piezo_strikes strikes.csv
    firstcontact import piezo_strikes/wav --events strikes.csv --sensor piezo --out pads

``hits.csv`` has the file and the sample of each strike, ``files.csv`` the pad and the surface of
each file. Mesh heads are soft, rubber and kick pads hard; a pad is one specimen, a file
one session.
"""

from __future__ import annotations

import csv
import sys
from pathlib import Path


def rows(path: Path) -> list[dict[str, str]]:
    """A table, row by row."""
    with path.open(encoding="utf-8", newline="") as table:
        return list(csv.DictReader(table))


def main(folder: Path, out: Path) -> None:
    """Join the tables."""
    files = {row["file"]: row for row in rows(folder / "files.csv")}
    with out.open("w", encoding="utf-8", newline="") as table:
        writer = csv.writer(table)
        # Strikes are marked on the first channel; a second one, of the rim, is in some files only.
        writer.writerow(["file", "onset_sample", "channel", "object", "specimen", "hardness_class"])
        for hit in rows(folder / "hits.csv"):
            pad = files[hit["file"]]
            hardness = "soft" if pad["surface"] == "mesh" else "hard"
            onset = hit["onset_sample"]
            writer.writerow([hit["file"], onset, 0, pad["pad"], pad["pad"], hardness])


if len(sys.argv) == 3:
    main(Path(sys.argv[1]), Path(sys.argv[2]))
else:
    print("give the folder of the set, and the table to write")
