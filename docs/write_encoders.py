"""Write the table of encoders in docs/reference/hands.md: the closing speed's error by rate.

The table lies between ``<!-- encoders: rates -->`` and ``<!-- /encoders -->``.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from firstcontact.core import ClosingSpeed
from firstcontact.core.text import percent
from firstcontact.signal import closing_speed
from firstcontact_lab.report.tables import fill, markdown_table

PAGE = Path(__file__).parent / "reference/hands.md"
RATES, STEPS = (30.0, 100.0, 500.0), (1e-3, 1e-4, 1e-5)
CLOSINGS, SEED = 2000, 47
#: Slowest and fastest finger, m/s, standard deviation of a change of speed in the last 100 ms, and
#: noise of a reported speed, as shares.
SPEEDS, CHANGE, NOISE = (0.05, 0.2), 0.1, 0.03
#: How a speed is measured, and whether it changes.
WAYS = (("positions", 0.0), ("given step", 0.0), ("positions", CHANGE), ("speeds", CHANGE))
HEAD = "rate | step | positions | given step | positions, changing | speeds, changing"


def closings(
    rate: float, step: float, way: str, change_by: float
) -> tuple[list[float], list[ClosingSpeed | None]]:
    """Return true speeds at the contact, and measured ones."""
    rng, true, made = np.random.default_rng(SEED), [], []
    for _ in range(CLOSINGS):
        speed, change = rng.uniform(*SPEEDS), change_by * rng.standard_normal()
        times = np.arange(-0.4, 0.0, 1 / rate) + rng.uniform(0, 1 / rate)
        late = (times + 0.1).clip(0)
        begin = speed / (1 + change)
        travel = begin * (times + change * late**2 / 0.2) + rng.uniform(0, step)
        reports = begin * (1 + change * late / 0.1) * (1 + NOISE * rng.standard_normal(len(times)))
        positions = np.round(travel / step) * step
        true.append(speed)
        made.append(
            closing_speed(
                times,
                positions,
                0.0,
                resolution=None if way == "positions" else step,
                speeds=reports if way == "speeds" else None,
            )
        )
    return true, made


def row(rate: float, step: float) -> list[str]:
    """Return a line of the table."""
    cells = [f"{rate:g} Hz", f"{1e3 * step:g} mm"]
    for way, change_by in WAYS:
        true, made = closings(rate, step, way, change_by)
        pairs = [(s, m) for s, m in zip(true, made, strict=True) if m is not None]
        error = np.array([m.speed / s - 1 for s, m in pairs])
        held = float(np.mean([abs(m.speed - s) <= 2 * m.error for s, m in pairs]))
        cells.append(f"{percent(float(np.sqrt(np.mean(error**2))))} ({percent(held, 0)})")
    return cells


def filled(text: str) -> str:
    """Return the page with its table in place."""
    rows = [row(rate, step) for rate in RATES for step in STEPS]
    return fill(text, "encoders", {"rates": markdown_table(HEAD, rows)})


if __name__ == "__main__":
    PAGE.write_text(filled(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
