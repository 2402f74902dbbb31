"""Time of ``firstcontact --help``, compared with an empty Python program.

The commands run in turn, so that other load on the machine affects all of them alike:
``python benchmarks/startup.py``.
"""

from __future__ import annotations

import argparse
import resource
import statistics
import subprocess
import sys
import time

COMMAND = ["-m", "firstcontact.cli.main"]
STARTED = {
    "python -c pass": ["-c", "pass"],
    "firstcontact --help": [*COMMAND, "--help"],
    "firstcontact live --help": [*COMMAND, "live", "--help"],
    "python -c 'import numpy'": ["-c", "import numpy"],
}


def seconds(arguments: list[str]) -> tuple[float, float]:
    """Run Python with these arguments. Return its wall-clock and processor time, s."""
    start = resource.getrusage(resource.RUSAGE_CHILDREN)
    began = time.perf_counter()
    subprocess.run([sys.executable, *arguments], check=True, stdout=subprocess.DEVNULL)
    clock = time.perf_counter() - began
    end = resource.getrusage(resource.RUSAGE_CHILDREN)
    spent = end.ru_utime + end.ru_stime - start.ru_utime - start.ru_stime
    return clock, spent


def main() -> dict[str, float]:
    """Measure all commands and print the table. Return the ratios by name."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--times", type=int, default=20)
    settings = parser.parse_args()
    for arguments in STARTED.values():  # warm the file cache
        seconds(arguments)
    spent: dict[str, list[tuple[float, float]]] = {name: [] for name in STARTED}
    for _ in range(settings.times):
        for name, arguments in STARTED.items():
            spent[name].append(seconds(arguments))
    nothing = statistics.median(cpu for _, cpu in spent["python -c pass"])
    ratios = {}
    for name, times in spent.items():
        clock = statistics.median(clock for clock, _ in times)
        cpu = statistics.median(cpu for _, cpu in times)
        print(
            f"{name:26} median of {settings.times}: {1e3 * clock:4.0f} ms, processor time "
            f"{1e3 * cpu:4.0f} ms, {cpu / nothing:4.1f} times an empty Python program"
        )
        if name.startswith("firstcontact"):
            ratios[f"{name}, against an empty Python program"] = nothing / cpu
    return ratios


if __name__ == "__main__":
    main()
