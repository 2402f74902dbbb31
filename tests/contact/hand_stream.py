"""Synthetic stream of a hand that closes repeatedly: rest, motor, contact, hold, opening."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from firstcontact.chain import Chain, EventKind, build_image
from firstcontact.core import Block, Calibration, Finger, VibrationCalibration, fingertip_layout

LAYOUT = fingertip_layout()
RATE = LAYOUT.rate
#: Of the piezos at rest, V; the running motor is three times as loud.
FLOOR = 0.005
CALIBRATION = Calibration(tuple(VibrationCalibration(f, FLOOR) for f in Finger))
UNLOADED = 2000
#: Kind of an event of the gate, and the first sample after it.
Turn = tuple[int, int]
OPENS, SHUTS = EventKind.CLOSING_BEGAN, EventKind.CLOSING_ENDED


def make_gate(calibration: Calibration | None = CALIBRATION) -> Chain:
    """Return a chain that only finds closings."""
    return Chain(build_image(RATE), LAYOUT, calibration)


def turns(gate: Chain, block: Block) -> list[Turn]:
    return [(event.kind, event.sample) for event in gate.take(block)]


@dataclass(frozen=True)
class Closing:
    """Sample numbers of the events in one closing."""

    motor: int
    first: int
    second: int
    release: int


def samples(seconds: float) -> int:
    return round(seconds * RATE)


def hand_stream(closings: int, seed: int = 0) -> tuple[NDArray[np.int16], list[Closing]]:
    """Return raw samples, shape (n, 16), and their closings."""
    rng = np.random.default_rng(seed)
    phases: list[NDArray[np.float64]] = []  # columns: two piezos in V, two loads, two strips
    truth: list[Closing] = []
    at = 0

    def phase(seconds: float, loud: float) -> NDArray[np.float64]:
        out = np.zeros((samples(seconds), 6))
        out[:, :2] = loud * FLOOR * rng.standard_normal((len(out), 2))
        phases.append(out)
        return out

    for _ in range(closings):
        at += len(phase(rng.uniform(0.3, 0.5), 1.0))
        motor = at
        closing = phase(rng.uniform(0.15, 0.2), 3.0)
        first = at = at + len(closing)
        offset = samples(rng.uniform(0.008, 0.03))
        touching = phase(0.12, 3.0)
        finger = int(rng.integers(2))
        t = np.arange(len(touching)) / RATE
        ring = 0.3 * np.exp(-t / 0.01) * np.sin(2 * np.pi * 150 * t)
        touching[:, finger] += ring
        touching[offset:, 1 - finger] += ring[: len(ring) - offset]
        touching[:, 4 + finger] = 1
        touching[offset:, 5 - finger] = 1
        touching[offset:, 2:4] = np.minimum(t[: len(t) - offset] / 0.05, 1.0)[:, None]
        at += len(touching)
        hold = phase(0.3, 1.0)
        hold[:, 2:] = 1
        remainder = at
        opening = phase(0.25, 3.0)
        fall = np.exp(-np.arange(len(opening)) / RATE / 0.03)
        opening[:, 2:4] = fall[:, None]
        opening[:200, :2] -= 0.2 * np.exp(-np.arange(200) / 60)[:, None]
        at += len(hold) + len(opening)
        truth.append(Closing(motor, first, first + offset, remainder))
    phase(0.4, 1.0)
    return raw(np.concatenate(phases)), truth


def raw(x: NDArray[np.float64]) -> NDArray[np.int16]:
    """Convert two piezos in V, two loads and two strips to raw samples."""
    out = np.zeros((len(x), 16), dtype=np.int16)
    volt = LAYOUT.channels[0].scale
    out[:, :2] = np.clip(x[:, :2] / volt + LAYOUT.channels[0].offset, 0, 32_736)
    out[:, 2:8] = (UNLOADED + 8000 * x[:, 2])[:, None]
    out[:, 8:14] = (UNLOADED + 8000 * x[:, 3])[:, None]
    out[:, 14:] = x[:, 4:]
    return out
