"""Fuzzer of all inputs with damaged data: ``python tests/fuzz/fuzz.py --help``.

The seed and a number define each input. Each must end with exit code 0 or 2 in bounded time and
memory, print one sentence, and leave no incomplete file. Any other behaviour is a finding.
"""

from __future__ import annotations

import argparse
import json
import os
import select
import shutil
import signal
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

# One core a worker; set before NumPy is there.
for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[_name] = "1"
os.environ.setdefault("MPLBACKEND", "Agg")

import fuzz_recordings  # noqa: E402
import fuzz_worker  # noqa: E402
from fuzz_seeds import Seeds, make_seeds  # noqa: E402

#: An input that takes longer hangs, s; its processor time is bounded more tightly.
HANGS = 30.0
#: Inputs that a process runs before a new one takes over.
LOT = 400
#: What is imported once, in the process that all others are forked from.
_COMMON = (
    "firstcontact.cli.verbs.evaluate", "firstcontact.cli.verbs.export",
    "firstcontact.cli.verbs.import_", "firstcontact.cli.verbs.inspect",
    "firstcontact.cli.verbs.label", "firstcontact.cli.verbs.live",
    "firstcontact.cli.verbs.record", "firstcontact.cli.verbs.train",
    "firstcontact.contact._detector_file", "firstcontact.device._opening",
    "firstcontact.models._training", "firstcontact.models._training",
    "firstcontact.recording._importing", "firstcontact.streaming._json_lines",
    "firstcontact.streaming._ledger", "firstcontact.streaming._session",
    "firstcontact.streaming._text", "pyarrow.parquet", "pyxdf", "scipy.io.matlab",
    "scipy.io.wavfile", "soundfile",
    "matplotlib.backends.backend_agg", "matplotlib.figure", "matplotlib.backends.backend_svg",
    "matplotlib.backends.backend_pdf", "sklearn.svm", "skops.io",
)  # fmt: skip


@dataclass
class Results:
    """Results of all inputs.

    Parameters
    ----------
    codes
        Number of each exit code, by route.
    seconds
        Processor time, by route.
    findings
        Findings, by number of the input.
    """

    codes: Counter[tuple[str, int]] = field(default_factory=Counter)
    seconds: Counter[str] = field(default_factory=Counter)
    findings: dict[int, list[str]] = field(default_factory=dict)
    inputs: int = 0

    def take(
        self, number: int, route: str, codes: Iterable[int], wrong: list[str], took: float = 0.0
    ) -> None:
        """Count one input."""
        self.inputs += 1
        self.seconds[route] += took
        self.codes.update((route, code) for code in codes)
        if wrong:
            self.findings[number] = [f"{route}: {sentence}" for sentence in wrong]


class _Worker:
    """Forked process that runs inputs, with a pipe for its results."""

    def __init__(self, seed: int, numbers: range, seeds: Seeds, place: Path) -> None:
        self.numbers = numbers
        self.running: int | None = None
        self.began = time.monotonic()
        self.place = place
        self._rest = b""
        place.mkdir()
        self.pipe, write = os.pipe()
        self.process = os.fork()
        if not self.process:
            code = 1
            try:
                os.close(self.pipe)
                _end_with_parent()
                say = os.fdopen(write, "w", buffering=1)
                fuzz_worker.work(seed, numbers, seeds, place, lambda line: print(line, file=say))
                code = 0
            finally:
                os._exit(code)
        os.close(write)

    def lines(self) -> tuple[list[dict[str, object]], bool]:
        """Return the new results of the process, and True if its pipe is closed."""
        data = os.read(self.pipe, 1 << 16)
        *lines, self._rest = (self._rest + data).split(b"\n")
        return [json.loads(line) for line in lines], not data

    def end(self) -> int:
        """Wait until the process ends. Return its exit status."""
        os.close(self.pipe)
        _, status = os.waitpid(self.process, 0)
        shutil.rmtree(self.place, ignore_errors=True)
        return status


def fuzz(seed: int, numbers: range, jobs: int, place: Path, findings: Path | None) -> Results:
    """Run inputs in several processes.

    Parameters
    ----------
    seed, numbers
        Seed, and numbers of the inputs.
    jobs
        Number of processes.
    place
        Empty folder for all files.
    findings
        File that gets a JSON line for each finding; None to write none.
    """
    from importlib import import_module

    for module in _COMMON:
        import_module(module)
    seeds = make_seeds(place / "seeds")
    fuzz_recordings.bomb()
    results = Results()
    waiting = [
        range(i, min(i + LOT, numbers.stop)) for i in range(numbers.start, numbers.stop, LOT)
    ]
    waiting.reverse()
    workers: list[_Worker] = []
    started = 0

    def report(number: int) -> None:
        if findings is not None and number in results.findings:
            with findings.open("a") as out:
                line = {"seed": seed, "number": number, "wrong": results.findings[number]}
                print(json.dumps(line), file=out)

    while waiting or workers:
        while waiting and len(workers) < jobs:
            workers.append(_Worker(seed, waiting.pop(), seeds, place / f"worker-{started}"))
            started += 1
        ready, _, _ = select.select([w.pipe for w in workers], [], [], 1.0)
        for worker in list(workers):
            closed = False
            if worker.pipe in ready:
                lines, closed = worker.lines()
                for line in lines:
                    if "began" in line:
                        worker.running, worker.began = int(str(line["began"])), time.monotonic()
                    else:
                        number = int(str(line["ended"]))
                        del line["ended"]
                        results.take(number, **line)  # type: ignore[arg-type]
                        report(number)
                        worker.numbers = range(number + 1, worker.numbers.stop)
                        worker.running = None
            late = worker.running is not None and time.monotonic() - worker.began > HANGS
            if late:
                os.kill(worker.process, signal.SIGKILL)
            if late or closed:
                status = worker.end()
                workers.remove(worker)
                if worker.running is not None or status:
                    number = worker.numbers.start if worker.running is None else worker.running
                    kind = f"hangs: more than {HANGS:g} s" if late else f"died: status {status}"
                    results.take(number, "?", (), [kind])
                    report(number)
                    worker.numbers = range(number + 1, worker.numbers.stop)
                if worker.numbers:
                    waiting.append(worker.numbers)
    return results


def _end_with_parent() -> None:
    """End this process together with its parent."""
    import ctypes

    ctypes.CDLL(None).prctl(1, signal.SIGKILL)


def _parsed() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[2])
    parser.add_argument("--count", type=int, default=1000, help="inputs")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--first", type=int, default=0, help="number of the first input")
    parser.add_argument("--jobs", type=int, default=len(os.sched_getaffinity(0)))
    parser.add_argument("--findings", type=Path, help="append findings to this file, JSON lines")
    parser.add_argument("--keep", type=Path, help="only make the first input, into this folder")
    return parser.parse_args()


def _place() -> Path:
    """Return a folder that is kept in memory, if there is one."""
    memory = Path("/dev/shm")
    return Path(tempfile.mkdtemp(prefix="fuzz-", dir=memory if memory.is_dir() else None))


def main() -> int:
    """Run the command line."""
    options = _parsed()
    place = _place()
    try:
        if options.keep:
            seeds = make_seeds(options.keep)
            folder = options.keep / "input"
            folder.mkdir()
            case = fuzz_worker.make_case(options.seed, options.first, seeds, folder)
            print(case.route)
            for words in case.commands:
                print("firstcontact", *map(repr, words))
            return 0
        numbers = range(options.first, options.first + options.count)
        began = time.monotonic()
        results = fuzz(options.seed, numbers, options.jobs, place, options.findings)
    finally:
        shutil.rmtree(place, ignore_errors=True)
    took = time.monotonic() - began
    for (route, code), count in sorted(results.codes.items()):
        print(f"{route:20} exit {code:3}: {count}")
    for route, seconds in results.seconds.most_common():
        print(f"{route:20} {seconds:.1f} s of processors")
    for number, wrong in sorted(results.findings.items()):
        for sentence in wrong:
            print(f"--seed {options.seed} --first {number}: {sentence}")
    rate = results.inputs / took
    print(
        f"{results.inputs} inputs, {len(results.findings)} findings, {took:.0f} s, "
        f"{rate:.0f} a second"
    )
    return 1 if results.findings else 0


if __name__ == "__main__":
    sys.exit(main())
