"""Table of contacts for recordings of drum pads, made from the two tables that come with them.

    python examples/strike_events.py piezo_strikes strikes.csv front_ends.csv noise.wav
    firstcontact import piezo_strikes/wav --events strikes.csv --sensor piezo --out pads

``hits.csv`` has the file and the sample of each strike. ``files.csv`` has the pad and the surface
of each file. Mesh heads count as soft, rubber and kick pads as hard. Each pad is one specimen. Each
file is one session.

One file contains the noise of the converter. The last 85 s of this file become ``noise.wav``; the
earlier part has strikes, and two knocks at 4.57 and 4.83 s. ``noise_volts.wav`` is the same noise
for ``simulate --noise``, where full scale is 1.65 V.
"""

from __future__ import annotations

import csv
import sys
from pathlib import Path

import numpy as np
from scipy.io import wavfile

#: File with noise, and length of its end with noise only, s.
NOISE, QUIET = "teensy4_0_noise_test.wav", 85.0
#: Factor from the converter's counts to a 16-bit WAV. The file has the raw counts of 12 bits over
#: 3.3 V, 0 to 4095. Full scale, 32768, is then 1.65 V around the middle.
VOLTS = 16


def rows(path: Path) -> list[dict[str, str]]:
    """Return the rows of a table."""
    with path.open(encoding="utf-8", newline="") as table:
        return list(csv.DictReader(table))


def main(folder: Path, out: Path, front_ends: Path, noise: Path) -> None:
    """Write the tables of strikes and of front ends, and the files with the noise."""
    files = {row["file"]: row for row in rows(folder / "files.csv")}
    with out.open("w", encoding="utf-8", newline="") as table:
        writer = csv.writer(table)
        # Strikes are marked on the first channel. Some files have a second channel for the rim.
        writer.writerow(["file", "onset_sample", "channel", "object", "specimen", "hardness_class"])
        for hit in rows(folder / "hits.csv"):
            pad = files[hit["file"]]
            hardness = "soft" if pad["surface"] == "mesh" else "hard"
            onset = hit["onset_sample"]
            writer.writerow([hit["file"], onset, 0, pad["pad"], pad["pad"], hardness])

    with front_ends.open("w", encoding="utf-8", newline="") as table:
        writer = csv.writer(table)
        writer.writerow(["session", "front_end"])
        for name, pad in files.items():
            writer.writerow([Path(name).stem, pad.get("front_end", "")])
    if (folder / "wav" / NOISE).exists():
        rate, samples = wavfile.read(folder / "wav" / NOISE)
        first = samples if samples.ndim == 1 else samples[:, 0]
        quiet = first[-round(QUIET * rate) :]
        wavfile.write(noise, rate, quiet)
        around = VOLTS * (quiet.astype(np.int32) - round(float(quiet.mean())))
        volts = noise.with_name(f"{noise.stem}_volts.wav")
        wavfile.write(volts, rate, np.clip(around, -32768, 32767).astype(np.int16))


if len(sys.argv) == 5:
    main(*map(Path, sys.argv[1:]))
else:
    print("give the folder of recordings, and the names of two tables and of the noise to write")
