"""Soak test of the live sources with faults: ``python tests/soak/soak.py --help``.

Each sender numbers its samples. Each source runs a live session that records, in a separate
process. At the end three statements must hold. Received and lost samples add up to the sent ones.
Each recorded sample holds its own number. All received samples are recorded. Any other result is a
finding.
"""

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from soak_links import LINKS, Link

from firstcontact.contact import ThresholdDetector
from firstcontact.core import Calibration, InputError, VibrationCalibration
from firstcontact.device import Health
from firstcontact.recording import Recording, read_recording
from firstcontact.streaming import Pipeline
from firstcontact.streaming.json_lines import JsonLinesSink
from firstcontact.streaming.session import LiveSession

#: Between two faults, s: the rate of a source is measured over some seconds.
PAUSE = 4.0, 8.0


def run_link(name: str, seconds: float, seed: int, folder: Path) -> dict[str, Any]:
    """Run a sender with its faults, and a session that records. Return counts and findings."""
    rng = Random(f"{seed} {name}")
    link = LINKS[name](folder, rng)
    over = threading.Event()
    injected: Counter[str] = Counter()
    wrong: list[str] = []

    def inject() -> None:
        until = time.monotonic() + seconds
        names: list[str] = []
        try:
            while (pause := rng.uniform(*PAUSE)) < until - time.monotonic():
                time.sleep(pause)
                names = names or rng.sample(sorted(link.faults), len(link.faults))
                fault = names.pop()
                link.faults[fault]()
                injected[fault] += 1
            time.sleep(PAUSE[0])
            link.finish()
        except Exception as error:
            wrong.append(f"the soak failed: {error!r}")
        over.set()

    with link.opened() as source, Path(os.devnull).open("w", encoding="utf-8") as nowhere:
        layout = source.descriptor.layout
        noise = Calibration(tuple(VibrationCalibration(f, 1.0) for f in layout.vibration_fingers))
        pipeline = Pipeline(layout, ThresholdDetector(10.0), None, noise)
        session = LiveSession(source, pipeline, recordings=folder)
        path = session.start_recording()
        injecting = threading.Thread(target=inject)
        injecting.start()
        memory = _peak_memory()
        try:
            session.run([JsonLinesSink(nowhere)], stopped=over.is_set)
        except InputError as error:
            wrong.append(f"the source ended: {error}")
        health, grown = source.health, _peak_memory() - memory
        injecting.join()
    counts, findings = check_counts(link, health, read_recording(path))
    return {
        **counts,
        "faults": dict(sorted(injected.items())),
        "damaged": health.bad_frames,
        "memory_grown": grown,
        "wrong": wrong + findings,
    }


def check_counts(
    link: Link, health: Health, recording: Recording
) -> tuple[dict[str, int], list[str]]:
    """Compare the counts and the recording of a source with the numbers in its samples.

    Returns
    -------
    counts : dict
        Samples sent, received, lost and recorded, epochs and gaps.
    wrong : list of str
        A sentence for each difference.
    """
    wrong: list[str] = []
    sent = gaps = drift = next_number = 0
    epochs = sorted({stretch.epoch for stretch in recording.stretches})
    parts = [epochs] if link.continuous else [[epoch] for epoch in epochs]
    for k, part in enumerate(parts):
        stretches = [s for s in recording.stretches if s.epoch in part]
        text = np.concatenate([link.numbers(s.data) for s in stretches])
        places = np.concatenate([s.first_sample + np.arange(len(s.data)) for s in stretches])
        off = _wrapped(text - places - (text[0] - places[0]), link.modulus)
        gaps += len(stretches) - 1
        drift = max(drift, int(np.abs(off).max()))
        # Samples between the numbers of the first and of the last one, as the sender has it.
        first = next_number + (int(text[0]) - next_number) % link.modulus
        last = first + int(places[-1] - places[0]) + int(off[-1])
        last = link.last.get(k, last)
        sent += last - first + 1
        next_number = 0 if link.restarts else last + 1
    counts = {
        "sent": sent,
        "received": health.samples,
        "lost": health.lost_samples,
        "recorded": recording.samples,
        "epochs": len(epochs),
        "gaps": gaps,
        "drift": drift,
    }
    slack = link.slack * gaps
    if abs(health.samples + health.lost_samples - sent) > slack:
        wrong.append(f"{health.samples} received and {health.lost_samples} lost of {sent} sent")
    if recording.samples != health.samples:
        wrong.append(f"{health.samples} received and {recording.samples} recorded")
    if drift > slack:
        wrong.append(f"samples are up to {drift} from where their numbers say")
    return counts, wrong


def _wrapped(numbers: NDArray[np.int64], modulus: int) -> NDArray[np.int64]:
    """Return numbers wrapped to the range of plus or minus half a modulus."""
    wrapped: NDArray[np.int64] = (numbers + modulus // 2) % modulus - modulus // 2
    return wrapped


def _peak_memory() -> int:
    """Return the peak memory of this process, kB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def soak(minutes: float, seed: int, links: list[str], out: Path) -> int:
    """Run the links in parallel and write their results. Return 1 if there are findings."""
    with tempfile.TemporaryDirectory(prefix="firstcontact-soak-") as place:
        processes = {}
        for name in links:
            folder = Path(place) / name
            folder.mkdir()
            words = ["--link", name, "--minutes", str(minutes), "--seed", str(seed)]
            processes[name] = subprocess.Popen(
                [sys.executable, __file__, *words, "--folder", str(folder)], stdout=subprocess.PIPE
            )
        results = {}
        for name, process in processes.items():
            errors, _ = process.communicate()
            lost = {"wrong": [f"it ended with code {process.returncode}"]}
            results[name] = json.loads(errors) if process.returncode == 0 else lost
    tree = {"minutes": minutes, "seed": seed, "links": results}
    out.write_text(json.dumps(tree, indent=1) + "\n", encoding="utf-8")
    for name, result in results.items():
        counts = ", ".join(f"{result.get(k)} {k}" for k in ("sent", "received", "lost", "recorded"))
        print(f"{name:6} {counts}; faults {sum(result.get('faults', {}).values())}")
        for sentence in result["wrong"]:
            print(f"       finding: {sentence}")
    return int(any(result["wrong"] for result in results.values()))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--minutes", type=float, default=60.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--links", nargs="+", choices=LINKS, default=list(LINKS))
    parser.add_argument("--out", type=Path, default=Path("soak.json"), help="results, JSON")
    parser.add_argument("--link", choices=LINKS, help=argparse.SUPPRESS)
    parser.add_argument("--folder", type=Path, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.link is None:
        return soak(options.minutes, options.seed, options.links, options.out)
    try:
        result = run_link(options.link, 60.0 * options.minutes, options.seed, options.folder)
    except pytest.skip.Exception as error:
        result = {"wrong": [f"{error}, or name the other links with --links"]}
    print(json.dumps(result))
    return 0


if __name__ == "__main__":
    sys.exit(main())
