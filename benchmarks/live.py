"""The live pipeline: how much faster than real time, and how late an estimate is.

The twin's running hand (60 s, closing some 30 times) is replayed through the pipeline in
blocks of 0.1 s and of 5 samples, as a device sends them, with an any-time model that answers
each millisecond and without. Beside it, what one would write
without streaming objects: detect and cut anew in all of the closing so far, and ask
scikit-learn's ``predict``. Then ``firstcontact live --device twin`` runs in real time, several
times, without a page, with one, and with one and a viewer: its own processor time (the twin is
another process) and its ledger, the run of the middle of each. Run with one thread:
``OMP_NUM_THREADS=1 python benchmarks/live.py``.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import numpy as np

from firstcontact.cli.twin_model import twin_model
from firstcontact.contact import Detector, detect, load_detector
from firstcontact.core import (
    Block,
    Calibration,
    Dataset,
    Finger,
    Physical,
    Pinch,
    VibrationCalibration,
    fingertip_layout,
)
from firstcontact.models import (
    BEFORE,
    LONGEST,
    InContextModel,
    SvmModel,
    Touches,
    load_anytime,
    load_interval,
    load_window_model,
    machine_of,
    shape_and_level,
)
from firstcontact.signal import contact_windows, samples_in
from firstcontact.streaming import ModelWithInterval, PinchDone, Pipeline
from firstcontact.twin import DeviceFilter, TwinStream

LAYOUT = fingertip_layout()
#: Runs in real time: words, with the page, with somebody who looks at it.
KINDS = (
    ("without a page", False, False),
    ("with the page", True, False),
    ("with the page and a viewer", True, True),
)
#: Samples of a frame, and of a block of 0.1 s.
FRAME, LONG = 5, 494


def blocks_of(data: np.ndarray, size: int) -> list[Block]:
    """A stream in blocks."""
    return [Block(data[i : i + size], i) for i in range(0, len(data), size)]


def replayed(pipeline: Pipeline, blocks: list[Block]) -> tuple[float, list[PinchDone]]:
    """Seconds that a stream took, and its pinches."""
    done = []
    begin = time.perf_counter()
    for block in blocks:
        for event in pipeline.update(block, time.monotonic()):
            if isinstance(event, PinchDone):
                done.append(event)
    return time.perf_counter() - begin, done


def one_answer(model: InContextModel, seed: int, times: int = 5000) -> str:
    """How long one answer of an any-time model takes, by the clock and by the processor's."""
    rng = np.random.default_rng(seed)
    after = samples_in(LONGEST, LAYOUT.rate)
    ring = np.exp(-np.arange(after) / 25) * np.sin(np.arange(after) / 8)
    signal = 0.005 * rng.standard_normal((1, samples_in(BEFORE, LAYOUT.rate) + after))
    signal[0, -after:] += 0.4 * ring
    unknown = np.full(1, np.nan)
    finger = np.zeros(1, np.intp)
    touch = Touches(
        signal.astype(np.float32), np.array([40]), finger, unknown, unknown, LAYOUT.rate
    )
    known = model.known(touch)
    spent = np.empty((times, 2))
    for n in range(times):
        began = time.perf_counter(), time.thread_time()
        model.answers(touch, known)
        spent[n] = time.perf_counter() - began[0], time.thread_time() - began[1]
    (wall, cpu), (wall99, cpu99) = 1e6 * np.percentile(spent, [50, 99], axis=0)
    return (
        f"one any-time answer: p50 {wall:.0f} us, p99 {wall99:.0f} us; of the processor's time p50 "
        f"{cpu:.0f} us, p99 {cpu99:.0f} us"
    )


def naive_seconds(
    data: np.ndarray, pinches: list[PinchDone], detector: Detector, model: SvmModel
) -> float:
    """Median seconds of an answer that is made anew from all of the closing so far."""
    arrays = model.to_arrays()
    c, gamma, epsilon = (float(p) for p in arrays["parameters"])
    machine = machine_of(model.spec.task, (c, gamma, epsilon))
    rng = np.random.default_rng(0)
    machine.fit(arrays["vectors"], rng.standard_normal(len(arrays["vectors"])))
    spent = []
    for pinch in pinches:
        for estimate in pinch.estimates:
            begin = time.perf_counter()
            so_far = Pinch(
                data[pinch.armed : estimate.complete + 1], LAYOUT, first_sample=pinch.armed
            )
            contacts = detect(detector, so_far)
            window, _ = contact_windows(Dataset((so_far,)), contacts[:1], model.spec.duration)
            machine.predict(shape_and_level(window, arrays["level"]))
            spent.append(time.perf_counter() - begin)
    return float(np.median(spent))


@contextmanager
def viewer(address: str) -> Iterator[None]:
    """Somebody who looks at the page and takes all that it sends."""
    from websockets.sync.client import connect

    with connect(address.replace("http", "ws") + "socket", compression=None) as line:
        reading = threading.Thread(target=lambda: [None for _ in line], daemon=True)
        reading.start()
        yield


def real_time(seconds: float, seed: int, page: bool, looked_at: bool) -> tuple[float, float, str]:
    """Share of a core in percent, median from block to estimate in ms, and all that was said."""
    command = [sys.executable, "-m", "firstcontact.cli.main", "live", "--device", "twin"]
    command += ["--seed", str(seed), "--seconds", str(seconds)]
    command += ["--page", "--port", "0"] if page else []
    with (
        subprocess.Popen(
            command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
        ) as live,
        ExitStack() as looking,
    ):
        assert live.stderr is not None
        said = ""
        for line in live.stderr:
            said += line
            if looked_at and line.startswith("page: "):
                looking.enter_context(viewer(line.split()[-1]))
    share = re.search(r"processor time ([\d.]+) %", said)
    compute = re.search(r"computing the estimate \(.*?\) +([\d.]+)", said)
    assert share is not None, said
    assert compute is not None, said
    return float(share[1]), float(compute[1]), said


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=60.0, help="of each stream")
    parser.add_argument("--seed", type=int, default=5, help="of the stream")
    parser.add_argument("--runs", type=int, default=3, help="in real time, of each kind; 0: none")
    settings = parser.parse_args()
    with tempfile.TemporaryDirectory() as cache:
        os.environ["XDG_CACHE_HOME"] = cache
        folder = twin_model("paper-rig", 0)
        detector, model = load_detector(folder), load_window_model(folder)
        models = [ModelWithInterval(model, load_interval(Path(folder)))]
        anytime = load_anytime(folder)
        assert isinstance(model, SvmModel)
        twin = TwinStream("paper-rig", None, settings.seed)
        data = DeviceFilter().update(twin.read(round(settings.seconds * LAYOUT.rate)))
        rest = Physical(LAYOUT, (0, 1))(data[: round(0.5 * LAYOUT.rate)])
        calibration = Calibration(
            tuple(VibrationCalibration(f, float(rest[:, i].std())) for i, f in enumerate(Finger))
        )

        print(one_answer(anytime, settings.seed))
        for size, running in ((LONG, anytime), (FRAME, anytime), (LONG, None), (FRAME, None)):
            pipeline = Pipeline(
                LAYOUT, detector, models, calibration, anytime=running, real_time=False
            )
            spent, done = replayed(pipeline, blocks_of(data, size))
            figures = pipeline.ledger.summary()
            how = "with" if running else "without"
            print(
                f"{how} an answer each millisecond, blocks of {size} samples: "
                f"{settings.seconds / spent:.0f} x real time; block to estimate "
                f"p50 {1e6 * figures['compute_p50']:.0f} us, "
                f"p99 {1e6 * figures['compute_p99']:.0f} us, {len(done)} pinches"
            )
        naive = naive_seconds(data, done, detector, model)
        print(
            f"the same answer made anew from the closing so far: p50 {1e6 * naive:.0f} us, "
            f"{naive / figures['compute_p50']:.1f} x as long"
        )

        for words, page, looked_at in KINDS if settings.runs else ():
            runs = sorted(
                real_time(settings.seconds, settings.seed, page, looked_at)
                for _ in range(settings.runs)
            )
            share, compute, said = runs[len(runs) // 2]
            shares = ", ".join(f"{run[0]:.1f}" for run in runs)
            print(
                f"\nin real time, {settings.seconds:g} s over a pseudo terminal, {words}: "
                f"{share} % of a core ({shares}), block to estimate p50 {compute} ms; load "
                f"{os.getloadavg()[0]:.1f}\n{said.rstrip()}"
            )


if __name__ == "__main__":
    main()
