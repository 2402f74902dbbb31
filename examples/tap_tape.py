"""WAV file at 48 kHz with simulated taps, as a disc at a sound input would record them.

    python examples/tap_tape.py --shore 29 --taps 10 --out taps.wav

One finger of the simulated hand taps a block, without a motor. The taps come from the twin, not
from a real sensor.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.io import wavfile

from firstcontact.core.layout import FINGERTIP_RATE, PIEZO_OFFSET_VOLTS
from firstcontact.signal import resample
from firstcontact.twin import draw_pinch
from firstcontact.twin.draw import condition
from firstcontact.twin.mechanics import BUFFER, INDENTATION
from firstcontact.twin.objects import block
from firstcontact.twin.pinch import integrate_pinch

RATE = 48_000
#: Rest before the first tap, and time between taps, s.
REST, APART = 2.5, 0.65
#: Length of a tap before and after its contact, s.
BEFORE, AFTER = 0.06, 0.09


def tap(shore: float, number: int, seed: int) -> tuple[np.ndarray, int]:
    """Return one tap at the fingertip's rate, full scale 1, and the sample of its contact."""
    draw = draw_pinch(seed, condition("paper-rig"), "1", block(shore), number)
    still = {"rotor": 0.0, "mesh": 0.0, "friction": 0.0, "click_rate": 0.0, "mains": 0.0}
    quiet = tuple(replace(n, **still, hum=0.0) for n in draw.noise)
    timing = draw.timing._replace(first=BEFORE, second=BEFORE + 2 * AFTER, first_is_index=True)
    _, motion = integrate_pinch(replace(draw, noise=quiet, timing=timing), duration=BEFORE + AFTER)
    signal = motion[:, 0, BUFFER] / PIEZO_OFFSET_VOLTS
    ends = np.ones(len(signal))
    fade = round(0.02 * FINGERTIP_RATE)
    ends[:fade], ends[-fade:] = np.linspace(0, 1, fade), np.linspace(1, 0, fade)
    return np.asarray(signal * ends), int(np.argmax(motion[:, 0, INDENTATION] > 0))


def tape(shore: float, taps: int, seed: int) -> np.ndarray:
    """Return the taps with rest between them, int16 at 48 kHz."""
    rng = np.random.default_rng(seed)
    out = np.zeros(round((REST + taps * APART + 1.0) * FINGERTIP_RATE))
    for k in range(taps):
        one, touch = tap(shore, k, seed)
        start = round((REST + k * APART) * FINGERTIP_RATE) - touch
        out[start : start + len(one)] += one
    fine = resample(out[:, None], FINGERTIP_RATE, RATE)[:, 0]
    fine += 0.0013 * rng.standard_normal(len(fine))  # noise of a cheap sound input
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
