"""Long WAV file with two knocks, and the table of the knocks' times.

    python examples/long_wav.py
    firstcontact import long.wav --events events.csv --sensor piezo --source synthetic --out knocks

The knocks are synthetic. The second command imports your own files in the same way.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.io import wavfile

RATE = 8000
noise = np.random.default_rng(0).normal(0, 20, 5 * RATE)
t = np.arange(round(0.03 * RATE)) / RATE
for onset, pitch in ((1.25, 200), (3.5, 1200)):
    start = round(onset * RATE)
    noise[start : start + len(t)] += 8000 * np.exp(-t / 0.005) * np.sin(2 * np.pi * pitch * t)
wavfile.write("long.wav", RATE, noise.astype(np.int16))
Path("events.csv").write_text(
    "onset_s,object,hardness_class\n1.25,foam mat,soft\n3.5,table,hard\n", encoding="utf-8"
)
print("long.wav and events.csv are written")
