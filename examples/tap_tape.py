"""What a disc at a sound input would hear of some taps, made by the twin: a WAV at 48 kHz.

    python examples/tap_tape.py --shore 29 --taps 10 --out taps.wav

One finger of the simulated hand taps a block, without a motor. Twin results, not a disc's.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.io import wavfile

from firstcontact.core import FINGERTIP_RATE, PIEZO_OFFSET_VOLTS
from firstcontact.signal import resample
from firstcontact.twin import BUFFER, INDENTATION, condition, draw_pinch, mechanics_of, object_named

RATE = 48_000
#: Rest before the first tap, and from tap to tap, s.
REST, APART = 2.5, 0.65
#: A tap's sound before and after it touches, s.
BEFORE, AFTER = 0.06, 0.09


def tap(shore: float, number: int, seed: int) -> tuple[np.ndarray, int]:
    """One tap at the fingertip's rate, full scale 1, around 0, and where it touches."""
    draw = draw_pinch(seed, condition("paper-rig"), "1", object_named(f"block {shore:g}"), number)
    still = {"rotor": 0.0, "mesh": 0.0, "friction": 0.0, "click_rate": 0.0, "mains": 0.0}
    quiet = tuple(replace(n, **still, hum=0.0) for n in draw.noise)
    timing = draw.timing._replace(first=BEFORE, second=BEFORE + 2 * AFTER, first_is_index=True)
    _, motion = mechanics_of(replace(draw, noise=quiet, timing=timing), duration=BEFORE + AFTER)
    heard = motion[:, 0, BUFFER] / PIEZO_OFFSET_VOLTS
    ends = np.ones(len(heard))
    fade = round(0.02 * FINGERTIP_RATE)
    ends[:fade], ends[-fade:] = np.linspace(0, 1, fade), np.linspace(1, 0, fade)
    return np.asarray(heard * ends), int(np.argmax(motion[:, 0, INDENTATION] > 0))


def tape(shore: float, taps: int, seed: int) -> np.ndarray:
    """The taps with rest between them, int16 at 48 kHz."""
    rng = np.random.default_rng(seed)
    out = np.zeros(round((REST + taps * APART + 1.0) * FINGERTIP_RATE))
    for k in range(taps):
        one, touch = tap(shore, k, seed)
        start = round((REST + k * APART) * FINGERTIP_RATE) - touch
        out[start : start + len(one)] += one
    fine = resample(out[:, None], FINGERTIP_RATE, RATE)[:, 0]
    fine += 0.0013 * rng.standard_normal(len(fine))  # what a cheap input hisses
    return (32767 * np.clip(fine, -1, 1)).astype(np.int16)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--shore", type=float, default=29.0, help="10, 20, 29, 43 or 60")
    parser.add_argument("--taps", type=int, default=10)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, default=Path("taps.wav"))
    said = parser.parse_args()
    wavfile.write(said.out, RATE, tape(said.shore, said.taps, said.seed))
    print(f"{said.taps} taps on {said.shore:g} Shore A: {said.out}")
