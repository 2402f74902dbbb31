"""How long the command takes to say what it can do, beside a Python that does nothing.

Each is started in turn, so that what else the machine does meets all alike:
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
    """Of the clock and of the processor, s."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    began = time.perf_counter()
    subprocess.run([sys.executable, *arguments], check=True, stdout=subprocess.DEVNULL)
    clock = time.perf_counter() - began
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return clock, spent


def main() -> None:
    """Start, time, compare."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--times", type=int, default=20)
    asked = parser.parse_args()
    for arguments in STARTED.values():  # their files are read once before
        seconds(arguments)
    spent: dict[str, list[tuple[float, float]]] = {name: [] for name in STARTED}
    for _ in range(asked.times):
        for name, arguments in STARTED.items():
            spent[name].append(seconds(arguments))
    nothing = statistics.median(cpu for _, cpu in spent["python -c pass"])
    for name, times in spent.items():
        clock = statistics.median(clock for clock, _ in times)
        cpu = statistics.median(cpu for _, cpu in times)
        print(
            f"{name:26} median of {asked.times}: {1e3 * clock:4.0f} ms, of the processor "
            f"{1e3 * cpu:4.0f} ms, {cpu / nothing:4.1f} times a Python that does nothing"
        )


if __name__ == "__main__":
    main()
