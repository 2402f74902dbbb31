"""Speed of the twin, accuracy of its time step, and memory for as many pinches as in the paper.

The reference for speed and waveform is SciPy's ``solve_ivp`` with the derivative in Python. Run it
on an idle machine: ``OMP_NUM_THREADS=1 python benchmarks/twin.py``.
"""

from __future__ import annotations

import argparse
import os
import resource
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

from firstcontact.core import Label
from firstcontact.core.layout import FINGERTIP_RATE
from firstcontact.recording import load_dataset
from firstcontact.twin import BLOCKS, CONDITIONS, TwinObject, draw_pinch
from firstcontact.twin import _run as run_module
from firstcontact.twin import pinch as pinch_module
from firstcontact.twin.draw import Condition, PinchDraw, draw_specimen
from firstcontact.twin.mechanics import BUFFER
from firstcontact.twin.objects import EVERYDAY_OBJECTS
from firstcontact.twin.pinch import PinchJob, excerpt, integrate_pinch, simulate_pinches
from firstcontact.twin.simulation import simulate_recordings

sys.path.append(str(Path(__file__).parents[1] / "tests" / "twin"))
from reference import FINGER_STATES, Piece, derivative

PAPER_RIG = CONDITIONS["paper-rig"]
EVERYDAY = CONDITIONS["everyday"]


def drawn(kind: TwinObject, number: int, condition: Condition = PAPER_RIG) -> PinchDraw:
    """Return the parameters of pinch ``number`` of an object. They are the same in each call."""
    specimen = draw_specimen(0, condition, kind, 0)
    return draw_pinch(0, condition, "benchmark", specimen, number)


def halving(pinches: int) -> float:
    """Return the change of a waveform if the time step is halved, as a share of its peak.

    It is the largest change in ``pinches`` pinches.
    """
    worst = 0.0
    for condition in (PAPER_RIG, EVERYDAY):
        for kind in (*BLOCKS, *EVERYDAY_OBJECTS):
            for i in range(pinches):
                coarse = integrate_pinch(drawn(kind, i, condition))[1][..., BUFFER]
                fine = integrate_pinch(drawn(kind, i, condition), substeps=2 * run_module.SUBSTEPS)[
                    1
                ][..., BUFFER]
                change = np.abs(coarse - fine).max(axis=0) / np.abs(fine).max(axis=0)
                worst = max(worst, float(change.max()))
    return worst


def captured(draw: PinchDraw) -> Piece:
    """Return the input that :func:`integrate_pinch` passes to the compiled integration."""
    taken: list[Piece] = []
    kernel = run_module.integrate_all
    run_module.integrate_all = lambda pieces: taken.extend(pieces) or [len(pieces[0].times)]
    try:
        integrate_pinch(draw)
    finally:
        run_module.integrate_all = kernel
    return taken[0]


def plain(draw: PinchDraw) -> np.ndarray:
    """Return the voltages of both buffers in a pinch, V, (samples, 2), from ``solve_ivp``."""
    piece = captured(draw)._replace(back_damping=0.0, gap=np.full(2, np.nan))
    times, touch, gap = piece.times, piece.touch, piece.gap
    grid = np.arange(piece.noise.shape[1]) * piece.noise_dt

    def rhs(t: float, x: np.ndarray) -> np.ndarray:
        push = np.array([np.interp(t, grid, line) for line in piece.noise])
        return derivative(x, piece, push, piece.speeds[0])

    x = piece.x.copy()
    out = np.empty((times.size, 2))
    order = np.argsort(touch)
    edges = [times[0], *touch[order], times[-1]]
    for stretch in range(3):
        begin, end = edges[stretch : stretch + 2]
        last = stretch == 2
        inside = (times >= begin) & ((times < end) | last)
        # The step must not exceed the spacing of the noise samples.
        solved = solve_ivp(
            rhs, (begin, end), x, "RK45", np.r_[times[inside], [] if last else end],
            max_step=piece.noise_dt, rtol=1e-6, atol=1e-12,
        )  # fmt: skip
        out[inside] = solved.y[[11, FINGER_STATES + 11], : inside.sum()].T
        x = solved.y[:, -1]
        if not last:
            f = order[stretch]
            gap[f] = x[6] - x[24] if f == 0 else x[18] + x[26]
    return out


def rate(folder: Path, workers: int, each: int) -> tuple[float, float]:
    """Return pinches simulated and written per second, and processor time of one pinch, s."""
    begin, busy = time.perf_counter(), time.process_time()
    simulate_recordings(folder, "paper-rig", each, 0, 0, workers)
    pinches = 5 * each
    return pinches / (time.perf_counter() - begin), (time.process_time() - busy) / pinches


def excerpts(workers: int, pinches: int) -> float:
    """Return pinches simulated per second, with only 60 ms around the first contact of each."""
    draws = [excerpt(drawn(BLOCKS[i % 5], i), 0.040) for i in range(pinches)]
    batches = [[PinchJob(draw, Label()) for draw in draws[i::25]] for i in range(25)]

    def simulated(batch: list[PinchJob]) -> None:
        list(simulate_pinches(batch, 0.060))

    begin = time.perf_counter()
    with ThreadPoolExecutor(workers) as pool:
        list(pool.map(simulated, batches))
    return pinches / (time.perf_counter() - begin)


def main() -> dict[str, float]:
    """Measure everything and print the results. Return the ratios by name."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--pinches", type=int, default=200, help="pinches of each block")
    parser.add_argument("--paper-size", action="store_true", help="also measure the full set")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        home = Path(folder)
        begin = time.perf_counter()
        simulate_recordings(home / "warm", "paper-rig", 1, 1, 0, 1)
        ready = time.perf_counter() - begin
        print(f"loading the kernel, not included in the times below: {ready:.1f} s")
        step = 1e6 / FINGERTIP_RATE / run_module.SUBSTEPS
        print(f"step {step:.0f} us; halved, waveforms move by at most {100 * halving(5):.2f} %")
        for workers in (1, 2):
            runs = [rate(home / f"{workers}-{i}", workers, options.pinches) for i in range(3)]
            most, busy = max(runs)
            print(
                f"{workers} workers: {most:.0f} pinches/s of {pinch_module.DURATION} s, "
                f"{1e3 * busy:.1f} ms of processor time each"
            )
            most = max(excerpts(workers, 2 * options.pinches) for _ in range(3))
            print(f"{workers} workers: {most:.0f} pinches/s of 60 ms around the contact")
        draw = drawn(BLOCKS[4], 0)
        begin = time.perf_counter()
        reference = plain(draw)[pinch_module.BURN_IN :]
        slow = time.perf_counter() - begin
        best = np.inf
        for _ in range(5):
            draw = drawn(BLOCKS[4], 0)
            begin = time.perf_counter()
            ours = integrate_pinch(draw)[1][..., BUFFER]
            best = min(best, time.perf_counter() - begin)
        off = np.abs(ours - reference).max() / np.abs(reference).max()
        print(
            f"solve_ivp with the derivative in Python: {slow:.2f} s a pinch, "
            f"{slow / best:.0f} times the twin's {1e3 * best:.1f} ms; "
            f"waveforms differ by {100 * off:.2f} %"
        )
        if options.paper_size:
            begin = time.perf_counter()
            simulate_recordings(home / "paper")
            made = time.perf_counter() - begin
            pinches = len(load_dataset(home / "paper"))
            peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
            print(
                f"paper size: {pinches} pinches in {made:.1f} s on {os.cpu_count()} cores; "
                f"peak memory with the set loaded {peak:.2f} GB"
            )
    return {"one pinch, against solve_ivp": slow / best}


if __name__ == "__main__":
    main()
