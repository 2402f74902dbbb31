"""Archive of your own signals that ``firstcontact import`` reads.

The signals here are synthetic: a damped oscillation after a known instant, louder and with a higher
frequency for harder objects. Replace them by your signals and keep the other lines.

    python examples/own_arrays.py
    firstcontact import own.npz --out own
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

RATE = 10_000.0  # Hz; at least 2 kHz
CONTACT = 1200  # sample number: 120 ms of quiet precede it
SHORE_A = (15.0, 35.0, 55.0)
SESSIONS = ("monday", "tuesday", "friday")
PINCHES = 8  # per object and session


def ring(shore_a: float, gain: float, rng: np.random.Generator) -> np.ndarray:
    """Return one synthetic piezo signal, V, shape (samples,)."""
    noise = 0.004 * rng.standard_normal(3000)
    t = np.arange(3000 - CONTACT) / RATE
    frequency = 120 + 4 * shore_a * np.exp(0.05 * rng.standard_normal())
    noise[CONTACT:] += (
        gain * 0.01 * shore_a * np.sin(2 * np.pi * frequency * t) * np.exp(-t / 0.008)
    )
    return noise


def main() -> None:
    """Write ``own.npz``."""
    rng = np.random.default_rng(0)
    piezo, shore_a, session = [], [], []
    for day in SESSIONS:
        gain = np.exp(0.1 * rng.standard_normal())  # set-ups differ from day to day
        for shore in SHORE_A:
            for _ in range(PINCHES):
                piezo.append(ring(shore, gain, rng))
                shore_a.append(shore)
                session.append(day)
    np.savez(
        Path("own.npz"),
        piezo=np.array(piezo, dtype=np.float32)[:, :, None],  # (pinches, samples, sensors)
        first_contact=np.full(len(piezo), CONTACT),
        shore_a=np.array(shore_a),
        specimen=np.array([f"foam {shore:g}" for shore in shore_a]),
        session=np.array(session),
        sample_rate_hz=RATE,
        piezo_unit="V",
    )
    print(f"own.npz: {len(piezo)} pinches")


if __name__ == "__main__":
    main()
