"""Time and memory of each step of a project, for several numbers of pinches.

Each step runs in a separate process on simulated recordings. The table shows wall time, processor
time and peak memory. It also shows the processor time per pinch, relative to that with the smallest
number of pinches. 100,000 pinches take 5 GB of disk. Run it with ``OMP_NUM_THREADS=1 python
benchmarks/scale.py --pinches 1000 10000 100000``.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

from machine import machine_name

#: Blocks of the simulated recordings.
BLOCKS = 5
#: Number of pinches of each of the eight unseen objects on which the models are evaluated.
OBJECT_PINCHES = 25

LOAD = """
import sys
import firstcontact as fc
dataset = fc.load(sys.argv[1])
print(sum(len(pinch.data) for pinch in dataset))
"""
DETECT = """
import sys
import firstcontact as fc
dataset = fc.load(sys.argv[1])
model = fc.load_model(sys.argv[2])
print(sum(contact is not None for contact in fc.detect(dataset, model)))
"""


@dataclass(frozen=True)
class Step:
    """Cost of one step.

    Parameters
    ----------
    pinches
        Number of pinches of blocks.
    name
        Name of the step.
    wall, cpu
        Wall time and processor time of the process and its children, s.
    peak
        Largest resident memory of one process, MB.
    """

    pinches: int
    name: str
    wall: float
    cpu: float
    peak: float


def measured(pinches: int, name: str, arguments: list[str]) -> Step:
    """Run the command with these arguments, and return its cost under the name ``name``.

    Raises
    ------
    SystemExit
        The command fails.
    """
    with tempfile.TemporaryFile("w+") as output:
        began = time.perf_counter()
        process = subprocess.Popen(arguments, stdout=output, stderr=output)
        _, status, usage = os.wait4(process.pid, 0)
        wall = time.perf_counter() - began
        if status:
            output.seek(0)
            raise SystemExit(f"{name} of {pinches} pinches failed:\n{output.read()[-2000:]}")
    cpu = usage.ru_utime + usage.ru_stime
    return Step(pinches, name, round(wall, 2), round(cpu, 2), round(usage.ru_maxrss / 1024, 1))


def steps(pinches: int, folder: Path) -> Iterator[Step]:
    """Run all steps on ``pinches`` pinches of blocks. Yield the cost of each when it has ended."""
    verb = [sys.executable, "-m", "firstcontact.cli.main"]
    data, unseen = folder / "pinches", folder / "unseen"
    model, network = folder / "model", folder / "network"
    made = ["simulate", "--out", str(data), "--pinches-per-object", "0"]
    made += ["--pinches-per-block", str(pinches // BLOCKS)]
    other = ["simulate", "--out", str(unseen), "--pinches-per-block", "0", "--seed", "1"]
    other += ["--pinches-per-object", str(OBJECT_PINCHES)]
    yield measured(pinches, "simulate", verb + made)
    subprocess.run(verb + other, check=True, capture_output=True)
    python = [sys.executable, "-c"]
    train = ["train", str(data), "--out", str(model)]
    adapt = ["adapt", str(data), "--out", str(network)]
    yield measured(pinches, "load", [*python, LOAD, str(data)])
    yield measured(pinches, "train", verb + train)
    yield measured(pinches, "adapt", verb + adapt)
    yield measured(pinches, "detect", [*python, DETECT, str(data), str(model)])
    evaluate = [*verb, "evaluate", str(model)]
    yield measured(pinches, "evaluate", [*evaluate, str(data)])
    yield measured(pinches, "evaluate on unseen objects", [*evaluate, str(unseen)])


def main() -> dict[str, float]:
    """Print the table. Return the processor time per pinch of the first set, relative to others."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--pinches", type=int, nargs="+", default=[100, 400], help="pinches of blocks"
    )
    parser.add_argument("--folder", type=Path, help="folder for recordings and models")
    parser.add_argument("--out", type=Path, help="JSON file for the figures")
    settings = parser.parse_args()
    rows: list[Step] = []
    ratios = {}
    for pinches in settings.pinches:
        with tempfile.TemporaryDirectory(dir=settings.folder) as folder:
            for step in steps(pinches, Path(folder)):
                first = next((row for row in rows if row.name == step.name), step)
                growth = (step.cpu / step.pinches) / (first.cpu / first.pinches)
                print(
                    f"{pinches} pinches, {step.name}: {step.wall:.1f} s, {step.cpu:.1f} s of "
                    f"processor ({growth:.2f} x per pinch), peak {step.peak:.0f} MB",
                    flush=True,
                )
                rows.append(step)
                ratios[f"{step.name}, a pinch of many against one of few"] = 1 / growth
    if settings.out is not None:
        report = {
            "machine": machine_name(),
            "cores": os.cpu_count(),
            "load": os.getloadavg()[0],
            "steps": [asdict(row) for row in rows],
        }
        settings.out.write_text(json.dumps(report, indent=1) + "\n")
    return ratios


if __name__ == "__main__":
    main()
