"""Measure how many faults the self-test finds in simulated hands, and write the table of them.

    python docs/write_check.py             write the table from docs/results
    python docs/write_check.py --measure   measure 200 healthy hands and 100 for each fault first

With --faults and --hands, other rows of the table stay as they are.

Each hand has its own pads, sensitivity, noise, offset, tester and size of fault. The limits follow
from the circuit and the mechanics. They were looked at with seeds below 1000 only.
"""

from __future__ import annotations

import argparse
import json
from collections import Counter
from collections.abc import Callable, Iterable
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any, Self

import numpy as np

from firstcontact.collect.check import check_fingertips
from firstcontact.core import Block, fingertip_layout
from firstcontact.core.layout import FINGERTIP_RATE
from firstcontact.device import Arrival, Descriptor, Health, Source
from firstcontact.recording import Marker
from firstcontact.twin.bench import BenchStream
from firstcontact.twin.sensor import DeviceFilter
from firstcontact_lab.report.tables import fill, markdown_table

RESULTS = Path(__file__).parent / "results" / "check.json"
PAGE = Path(__file__).parent / "reference" / "fingertip.md"
#: Healthy hands, hands of each fault, first random seed, and time for the drift, s.
HEALTHY, HANDS, SEED, DRIFT = 200, 100, 3000, 30.0
#: Least share of the faults and largest share of false verdicts that we aim for.
FOUND, FALSE = 0.95, 0.02
CONDITIONS = ("paper-rig", "everyday")
#: Samples of an arrival, 10 ms, and number of arrivals of a read.
FRAME, READ = 50, 25
#: Name and check of each fault.
CHECKS = {
    "offset": ("wrong offset, 60 to 500 mV", "offset"),
    "noise": ("noise, 15 to 60 mV before smoothing", "noise"),
    "hum": ("hum of 50 or 60 Hz, 30 to 200 mV", "hum"),
    "swapped": ("cables of the fingers exchanged", "fingers"),
    "polarity": ("wires of the disc exchanged", "polarity"),
    "open-disc": ("broken wire of the disc", "sensitivity"),
    "glue": ("badly glued disc, 3 to 15 % of its signal", "sensitivity"),
    "epoxy": ("disc in epoxy: corners −3 to −8 times the middle", "places"),
    "clipping": ("8 to 10 times the gain", "clipping"),
    "rattle": ("loose mount, 2 to 10 % of its stiffness", "rattle"),
    "open-row": ("broken row of the force array", "force array"),
    "open-column": ("broken column", "force array"),
    "shorted-rows": ("two connected rows", "force array"),
    "shorted-columns": ("two connected columns", "force array"),
    "lost": ("0.1 to 2 % of the frames lost", "lost samples"),
    "jitter": ("stream held back for 30 to 80 ms", "jitter"),
    "drift": ("drift of 40 to 400 mV in five minutes", "drift"),
}


class BenchSource(Source):
    """Source of the simulated fingertips on a bench, in this process and without a clock."""

    name = "bench"
    descriptor = Descriptor(fingertip_layout(), "docs/write_check.py", "simulated fingertip")

    def __init__(self, condition: str, seed: int, fault: str = "") -> None:
        self.bench = BenchStream(condition, seed, fault)
        self._filter = DeviceFilter()
        self._rng = np.random.default_rng([seed, 1])
        self._sample = self._lost = 0
        self._markers: list[Marker] = []
        self.twin_hand = condition, seed

    @property
    def health(self) -> Health:
        """Counts of samples."""
        return Health(True, samples=self._sample - self._lost, lost_samples=self._lost)

    ended = False

    def read(self, timeout: float, least: int = 1) -> list[Arrival]:
        """Return the next samples, frame by frame, unless there is no time."""
        if not timeout:
            return []
        data = self._filter.update(self.bench.read(FRAME * READ))
        markers, self._markers = tuple(self._markers), []
        arrivals = []
        for k in range(0, len(data), FRAME):
            block = Block(data[k : k + FRAME], self._sample)
            self._sample += FRAME
            if self.bench.link.loses():
                self._lost += FRAME
                continue
            # A healthy link delays a frame by half a millisecond on average (assumption).
            ready = self._sample / FINGERTIP_RATE + self._rng.exponential(5e-4)
            arrivals.append(Arrival(block, self.bench.link.release(ready), markers))
            markers = ()
        return arrivals

    def mark(self, text: str) -> None:
        """Ignore a marker."""

    def order(self, text: str) -> None:
        """Give the tester a task, and answer as the twin does."""
        self.bench.obey(text.removeprefix("tester:").strip())
        self._markers = [Marker(self._sample, f"twin: told {text}")]

    def close(self) -> None:
        """Do nothing."""

    def __enter__(self) -> Self:
        return self


def test_hand(fault: str, seed: int) -> list[str]:
    """Return the names of the checks that find a fault in a hand.

    Half of the hands are everyday.
    """
    drift = DRIFT if fault in ("", "drift") else 0.0
    with BenchSource(CONDITIONS[seed % 2], seed, fault) as source:
        _, verdicts = check_fingertips(source, drift=drift)
    return [v.check for v in verdicts if not v.is_good]


def measure(fault: str, seeds: Iterable[int], run: Callable[..., Any] = map) -> dict[str, Any]:
    """Return the number of hands, of found faults, and of each other verdict."""
    results = list(run(partial(test_hand, fault), seeds))
    check = CHECKS[fault][1] if fault else None
    others = Counter(name for names in results for name in set(names) if name != check)
    found = sum(check in names if check else bool(names) for names in results)
    return {"hands": len(results), "found": found, "others": dict(sorted(others.items()))}


def table(results: dict[str, dict[str, Any]]) -> str:
    """Return the rows of the results as Markdown."""
    rows = []
    for fault, row in results.items():
        title, check = CHECKS[fault] if fault else ("**none**: false verdicts", "any")
        words = ", ".join(f"{name} {count}" for name, count in row["others"].items())
        share = row["found"] / row["hands"]
        missed = "" if (share >= FOUND if fault else share <= FALSE) else ", **misses the goal**"
        rows.append((title, check, f"{row['found']} of {row['hands']}{missed}", words))
    head = "fault put into the circuit | check | found | other verdicts in these hands"
    return markdown_table(head, rows)


def filled(text: str) -> str:
    """Return the page with the table of the stored results."""
    return fill(text, "check", {"faults": table(json.loads(RESULTS.read_text("utf-8"))["faults"])})


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--measure", action="store_true", help="measure first")
    parser.add_argument("--healthy", type=int, default=HEALTHY)
    parser.add_argument("--hands", type=int, default=HANDS)
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--faults", nargs="+", default=list(CHECKS), help="measure these only")
    options = parser.parse_args()
    if options.measure:
        rows = json.loads(RESULTS.read_text("utf-8"))["faults"]
        with ProcessPoolExecutor(options.workers) as pool:
            for fault in ("", *options.faults) if options.healthy else options.faults:
                hands = options.hands if fault else options.healthy
                seeds = range(options.seed, options.seed + hands)
                run = partial(pool.map, chunksize=5)
                rows[fault] = measure(fault, seeds, run) | {"first_seed": options.seed}
                print(fault or "none", rows[fault], flush=True)
                command = "python docs/write_check.py --measure --faults FAULT --hands HANDS"
                results = {"command": command, "faults": rows}
                RESULTS.write_text(json.dumps(results, indent=1) + "\n", "utf-8")
    PAGE.write_text(filled(PAGE.read_text("utf-8")), "utf-8")
