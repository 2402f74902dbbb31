"""Run all benchmarks, and compare their ratios with those of an earlier run.

Each other program in this folder measures how many times faster our code is than what a user would
otherwise run. The function ``main`` of each returns these ratios by name. Ratios that fell by more
than 20 % are shown. Run it on an idle machine: ``python benchmarks/run.py --out
docs/results/benchmarks.json``.
"""

from __future__ import annotations

import argparse
import json
import os
import runpy
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from machine import machine_name

HERE = Path(__file__).parent
#: Ratios of the last committed run.
COMMITTED = HERE.parent / "docs" / "results" / "benchmarks.json"
#: Largest share by which a ratio may fall without being shown.
NOISE = 0.2
#: Each benchmark works on one thread.
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")


def programs() -> list[Path]:
    """Return the paths of the benchmarks: all other programs in this folder."""
    return [p for p in sorted(HERE.glob("*.py")) if p.name not in ("run.py", "machine.py")]


def ratios_of(program: Path) -> dict[str, float]:
    """Run a benchmark in a process of its own, and return its ratios by name.

    Raises
    ------
    SystemExit
        The benchmark fails.
    """
    with tempfile.NamedTemporaryFile("r") as file:
        command = [sys.executable, __file__, "--one", str(program), "--out", file.name]
        if subprocess.run(command, env={**os.environ, **ONE_THREAD}).returncode:
            raise SystemExit(f"{program} failed: its error is above")
        return json.loads(file.read())


def slower(earlier: dict[str, float], now: dict[str, float]) -> list[str]:
    """Return a line of text for each ratio that is missing, or fell by more than ``NOISE``."""
    return [
        f"slower than before: {name}: {now.get(name, 'no ratio')} instead of {ratio} times as fast"
        for name, ratio in earlier.items()
        if not now.get(name, 0.0) >= (1 - NOISE) * ratio
    ]


def main() -> None:
    """Run the benchmarks and print ratios that fell."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--one", type=Path, help="run only this program")
    parser.add_argument("--out", type=Path, help="JSON file for the ratios")
    parser.add_argument(
        "--earlier", type=Path, default=COMMITTED, help="JSON file of an earlier run"
    )
    settings = parser.parse_args()
    if settings.one is not None:
        sys.argv = [str(settings.one)]  # the program has its own options
        found = runpy.run_path(str(settings.one))["main"]()
        settings.out.write_text(json.dumps(found))
        return
    earlier = json.loads(settings.earlier.read_text()) if settings.earlier.is_file() else None
    if settings.out is not None:
        settings.out.touch()  # now, so that a wrong path is found at the start
    ratios: dict[str, float] = {}
    seconds: dict[str, float] = {}
    for program in programs():
        print(f"\n== {program.name}", flush=True)
        began = time.perf_counter()
        ratios |= {f"{program.stem}: {k}": round(v, 3) for k, v in ratios_of(program).items()}
        seconds[program.stem] = round(time.perf_counter() - began, 1)
    print(f"\n{sum(seconds.values()):.0f} s on {machine_name()}")
    if earlier is not None:
        print(f"compared with {settings.earlier} ({earlier['machine']}):")
        print("\n".join(slower(earlier["ratios"], ratios)) or "no ratio fell by more than 20 %")
    if settings.out is not None:
        report = {
            "machine": machine_name(),
            "cores": os.cpu_count(),
            "load": round(os.getloadavg()[0], 2),
            "seconds": seconds,
            "ratios": ratios,
        }
        settings.out.write_text(json.dumps(report, indent=1) + "\n")


if __name__ == "__main__":
    main()
