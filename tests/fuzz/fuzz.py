"""Fuzzer of all inputs with damaged data: ``python tests/fuzz/fuzz.py --help``.

The seed and a number define each input. Each must end with exit code 0 or 2 in bounded time and
memory, print one sentence, and leave no incomplete file. Any other behaviour is a finding.
"""

import argparse
import json
import multiprocessing
import os
import shutil
import sys
import tempfile
import time
from collections import Counter
from importlib import import_module
from multiprocessing.connection import wait
from pathlib import Path
from typing import Any

# One core a worker; set before NumPy is there.
for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[_name] = "1"
os.environ.setdefault("MPLBACKEND", "Agg")
sys.path.append(str(Path(__file__).parents[1]))

import fuzz_worker  # noqa: E402
from fuzz_recordings import bomb  # noqa: E402
from fuzz_seeds import make_seeds  # noqa: E402
from fuzz_ways import make_case  # noqa: E402

#: Number of inputs that a process runs before a new one takes over.
LOT = 400
#: Modules that are imported once, in the process from which all others are forked.
_COMMON = (
    "firstcontact.cli.verbs.evaluate", "firstcontact.cli.verbs.export",
    "firstcontact.cli.verbs.import_", "firstcontact.cli.verbs.inspect",
    "firstcontact.cli.verbs.label", "firstcontact.cli.verbs.live",
    "firstcontact.cli.verbs.record", "firstcontact.cli.verbs.train",
    "pyarrow.parquet", "pyxdf", "scipy.io.matlab", "scipy.io.wavfile", "soundfile",
    "matplotlib.backends.backend_agg", "matplotlib.backends.backend_svg",
    "matplotlib.backends.backend_pdf", "sklearn.svm", "skops.io",
)  # fmt: skip


def fuzz(seed: int, numbers: range, jobs: int, place: Path) -> list[dict[str, Any]]:
    """Run inputs in several processes. Return their results.

    Parameters
    ----------
    seed, numbers
        Seed, and numbers of the inputs.
    jobs
        Number of processes.
    place
        Empty folder for all files.
    """
    for module in _COMMON:
        import_module(module)
    seeds = make_seeds(place / "seeds")
    bomb()  # made once, for all workers
    context = multiprocessing.get_context("fork")
    waiting = [numbers[i : i + LOT] for i in range(0, len(numbers), LOT)][::-1]
    running: dict[int, tuple[Any, range, Path]] = {}
    results: list[dict[str, Any]] = []
    started = 0
    while waiting or running:
        while waiting and len(running) < jobs:
            lot, folder = waiting.pop(), place / f"worker-{started}"
            started += 1
            arguments = (seed, lot, seeds, folder)
            process = context.Process(target=fuzz_worker.work, args=arguments, daemon=True)
            process.start()
            running[process.sentinel] = process, lot, folder
        for sentinel in wait(list(running)):
            process, lot, folder = running.pop(sentinel)  # type: ignore[index]
            process.join()
            done = [json.loads(line) for line in (folder / "results").open()]
            rest = lot[len(done) :]
            if process.exitcode and rest:
                wrong = [f"it hangs or died: status {process.exitcode}"]
                done.append({"number": rest[0], "route": "?", "codes": [], "wrong": wrong})
                rest = rest[1:]
            if rest:
                waiting.append(rest)
            results += done
            shutil.rmtree(folder, ignore_errors=True)
    return results


def _parsed() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[2])
    parser.add_argument("--count", type=int, default=1000, help="inputs")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--first", type=int, default=0, help="number of the first input")
    parser.add_argument("--jobs", type=int, default=len(os.sched_getaffinity(0)))
    parser.add_argument("--findings", type=Path, help="append findings to this file, JSON lines")
    parser.add_argument("--keep", type=Path, help="only make the first input, into this folder")
    return parser.parse_args()


def main() -> int:
    """Run the command line."""
    options = _parsed()
    if options.keep:
        seeds = make_seeds(options.keep)
        folder = options.keep / "input"
        folder.mkdir()
        case = make_case(options.seed, options.first, seeds, folder)
        print(case.route)
        for words in case.commands:
            print("firstcontact", *map(repr, words))
        return 0
    began = time.monotonic()
    memory = Path("/dev/shm")  # a folder that is kept in memory, if there is one
    place = Path(tempfile.mkdtemp(prefix="fuzz-", dir=memory if memory.is_dir() else None))
    try:
        numbers = range(options.first, options.first + options.count)
        results = fuzz(options.seed, numbers, options.jobs, place)
    finally:
        shutil.rmtree(place, ignore_errors=True)
    took = time.monotonic() - began
    codes = Counter((result["route"], code) for result in results for code in result["codes"])
    for (route, code), count in sorted(codes.items()):
        print(f"{route:20} exit {code:3}: {count}")
    findings = sorted((r for r in results if r["wrong"]), key=lambda result: result["number"])
    for finding in findings:
        for sentence in finding["wrong"]:
            print(f"--seed {options.seed} --first {finding['number']}: {sentence}")
        if options.findings:
            with options.findings.open("a") as out:
                print(json.dumps({"seed": options.seed, **finding}), file=out)
    rate = len(results) / took
    print(
        f"{len(results)} inputs, {len(findings)} findings, {took:.0f} s, {rate:.0f} inputs a second"
    )
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
