"""WAV file at 48 kHz with simulated taps, as a disc at a sound input would record them.

    python examples/tap_tape.py --shore 29 --taps 10 --out taps.wav

One finger of the simulated hand taps a block, without a motor. The taps come from the twin, not
from a real sensor.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from scipy.io import wavfile

from firstcontact.core.layout import FINGERTIP_RATE
from firstcontact.signal import resample
from firstcontact.twin.samples import NOISE, strike

RATE = 48_000
#: Rest before the first tap, and time between taps, s.
REST, APART = 2.5, 0.65


def tape(shore: float, taps: int, seed: int) -> np.ndarray:
    """Return the taps with rest between them, int16 at 48 kHz."""
    rng = np.random.default_rng(seed)
    out = np.zeros(round((REST + taps * APART + 1.0) * FINGERTIP_RATE))
    for k in range(taps):
        one, touch = strike(shore, k, seed)
        start = round((REST + k * APART) * FINGERTIP_RATE) - touch
        out[start : start + len(one)] += one
    fine = resample(out[:, None], FINGERTIP_RATE, RATE)[:, 0]
    fine += NOISE * rng.standard_normal(len(fine))
    return (32767 * np.clip(fine, -1, 1)).astype(np.int16)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--shore", type=float, default=29.0, help="10, 20, 29, 43 or 60")
    parser.add_argument("--taps", type=int, default=10)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, default=Path("taps.wav"))
    settings = parser.parse_args()
    wavfile.write(settings.out, RATE, tape(settings.shore, settings.taps, settings.seed))
    print(f"{settings.taps} taps on {settings.shore:g} Shore A: {settings.out}")
