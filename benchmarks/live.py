"""Speed of the live pipeline and latency of its estimates.

A stream of the twin (60 s with some 30 closings) is replayed through the pipeline, in blocks of
0.1 s and in blocks of 5 samples, as a device sends them. The pipeline uses the network or a window
model. For comparison, the naive form processes the whole closing so far again for each estimate,
and calls scikit-learn's ``predict``.

``firstcontact live --device twin`` then runs in real time over a pseudo terminal, several
times without a page and several times with a page and a client of it. The main result is the share
of closings with an estimate in time: available before the second contact, by the clock, with all
delays. ``--disturbed`` adds one busy process per core, and another one that is stopped and
continued at random for 10 ms. ``--out`` writes these figures as JSON. Run it with one thread:
``OMP_NUM_THREADS=1 python benchmarks/live.py``.
"""

from __future__ import annotations

import argparse
import itertools
import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, nullcontext
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from machine import machine_name

from firstcontact.contact import Detector, detect
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
from firstcontact.models import Touches, load_model
from firstcontact.models.anytime import Predictor, PredictorLadder
from firstcontact.models.rig.rig_model import RigModel
from firstcontact.models.windows.svm import SvmModel, shape_and_level, svm_machine
from firstcontact.signal import contact_windows, samples_in
from firstcontact.streaming import PinchDone, Pipeline
from firstcontact.streaming.twin import twin_model
from firstcontact.twin import TwinStream
from firstcontact.twin.sensor import DeviceFilter

LAYOUT = fingertip_layout()
#: Samples of a frame, and of a block of 0.1 s.
FRAME, LONG = 5, 494


def split(data: np.ndarray, size: int) -> list[Block]:
    """Return an array of samples in blocks of ``size`` samples."""
    return [Block(data[i : i + size], i) for i in range(0, len(data), size)]


def replayed(pipeline: Pipeline, blocks: list[Block]) -> tuple[float, list[PinchDone]]:
    """Pass all blocks to a pipeline. Return the time, s, and the pinches that it reports."""
    pinches = []
    begin = time.perf_counter()
    for block in blocks:
        for event in pipeline.update(block, time.monotonic()):
            if isinstance(event, PinchDone):
                pinches.append(event)
    return time.perf_counter() - begin, pinches


def one_answer(model: RigModel, seed: int, times: int = 5000) -> str:
    """Return a line with the wall-clock and processor time of one prediction of the model."""
    rng = np.random.default_rng(seed)
    samples = samples_in(Touches.LONGEST, LAYOUT.rate)
    ring = np.exp(-np.arange(samples) / 25) * np.sin(np.arange(samples) / 8)
    signal = 0.005 * rng.standard_normal((1, samples_in(Touches.BEFORE, LAYOUT.rate) + samples))
    signal[0, -samples:] += 0.4 * ring
    finger = np.zeros(1, np.intp)
    touch = Touches.from_signals(signal.astype(np.float32), np.array([40]), finger, LAYOUT.rate)
    spent = np.empty((times, 2))
    for n in range(times):
        began = time.perf_counter(), time.thread_time()
        model.predict(touch)
        spent[n] = time.perf_counter() - began[0], time.thread_time() - began[1]
    (wall, cpu), (wall99, cpu99) = 1e6 * np.percentile(spent, [50, 99], axis=0)
    return (
        f"one any-time prediction: p50 {wall:.0f} us, p99 {wall99:.0f} us; processor time p50 "
        f"{cpu:.0f} us, p99 {cpu99:.0f} us"
    )


def naive_seconds(
    data: np.ndarray, pinches: list[PinchDone], detector: Detector, model: SvmModel
) -> float:
    """Return the median time of one naive prediction, s: it processes the whole closing so far."""
    arrays = model.to_arrays()
    c, gamma, epsilon = (float(p) for p in arrays["parameters"])
    machine = svm_machine(model.spec.task, (c, gamma, epsilon))
    rng = np.random.default_rng(0)
    machine.fit(arrays["vectors"], rng.standard_normal(len(arrays["vectors"])))
    spent = []
    for pinch in pinches:
        for estimate in pinch.estimates:
            begin = time.perf_counter()
            so_far = Pinch(
                data[pinch.start : estimate.complete + 1], LAYOUT, first_sample=pinch.start
            )
            contacts = detect(detector, so_far)
            window, _ = contact_windows(Dataset((so_far,)), contacts[:1], model.spec.duration)
            machine.predict(shape_and_level(window, arrays["level"]))
            spent.append(time.perf_counter() - begin)
    return float(np.median(spent))


@contextmanager
def viewer(address: str) -> Iterator[None]:
    """Connect to the live page's socket at ``address``. Read all messages until the block ends."""
    from websockets.sync.client import connect

    with connect(address.replace("http", "ws") + "socket", compression=None) as line:
        reading = threading.Thread(target=lambda: [None for _ in line], daemon=True)
        reading.start()
        yield


@contextmanager
def disturbance() -> Iterator[None]:
    """Keep the computer busy within the ``with`` block.

    One process keeps each core busy. Another one is stopped and continued at random.
    """
    ended = threading.Event()
    busy = [sys.executable, "-c", "while True: pass"]
    processes = [subprocess.Popen(busy) for _ in range((os.cpu_count() or 1) + 1)]

    def stop_and_continue() -> None:
        rng = np.random.default_rng(0)
        while not ended.is_set():
            processes[-1].send_signal(signal.SIGSTOP)
            time.sleep(0.010)
            processes[-1].send_signal(signal.SIGCONT)
            time.sleep(rng.uniform(0.0, 0.1))

    thread = threading.Thread(target=stop_and_continue)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()
        for process in processes:
            process.kill()
            process.wait()


@dataclass(frozen=True)
class RealTime:
    """Results of one run in real time, and the machine that it ran on.

    Parameters
    ----------
    machine, cores, load
        Processor, number of its cores, and load of the last minute at the end of the run.
    viewer
        True if the page was served to a client on the same machine.
    closings, with_second
        Number of closings, and of those with a second contact.
    in_force, in_force_share
        Number and share of closings whose estimate was available when the second finger touched.
    missed_offsets_ms
        Times from the first to the second contact, in closings whose second finger touched before
        an estimate was available.
    first_pinch_ms, compute_ms
        Time to compute an estimate, without waiting and transport, ms: for the first pinch of the
        session, and median, 99th percentile and maximum over all pinches.
    first_ms, later_ms
        Times from the last needed sample to each closing's first estimate, and to all later
        estimates, with waiting and transport, ms, ascending.
    core_share
        Processor time of the command, without the twin's process, as a share of one core.
    """

    machine: str
    cores: int
    load: float
    viewer: bool
    closings: int
    with_second: int
    in_force: int
    in_force_share: float
    missed_offsets_ms: list[float]
    first_pinch_ms: float
    compute_ms: tuple[float, float, float]
    first_ms: list[float]
    later_ms: list[float]
    core_share: float

    @property
    def words(self) -> str:
        """Results of the run as text on one line."""
        p50, p99, longest = self.compute_ms
        return (
            f"estimate in time in {self.in_force} of {self.closings} closings "
            f"({100 * self.in_force_share:.0f} %); computing p50 {p50:.2f} ms, "
            f"p99 {p99:.2f} ms, longest {longest:.2f} ms, first of the session "
            f"{self.first_pinch_ms:.2f} ms; {100 * self.core_share:.1f} % of a core; load "
            f"{self.load:.1f}"
        )


#: Fields that the file has for all runs together.
OF_ALL = ("first_ms", "later_ms")


def real_time(seconds: float, seed: int, looked_at: bool) -> RealTime:
    """Run ``firstcontact live`` on the twin for ``seconds`` s, and return its results.

    The samples come over the twin's pseudo terminal. With ``looked_at``, the page is served to a
    client.
    """
    command = [sys.executable, "-m", "firstcontact.cli.main", "live", "--device", "twin", "--json"]
    command += ["--seed", str(seed), "--seconds", str(seconds)]
    command += ["--page", "--port", "0"] if looked_at else []
    with (
        tempfile.TemporaryFile("w+") as lines,
        subprocess.Popen(command, stdout=lines, stderr=subprocess.PIPE, text=True) as live,
        ExitStack() as looking,
    ):
        assert live.stderr is not None
        output = ""
        for line in live.stderr:
            output += line
            if looked_at and line.startswith("page: "):
                looking.enter_context(viewer(line.split()[-1]))
        lines.seek(0)
        events = [json.loads(line) for line in lines]
    share = re.search(r"processor time ([\d.]+) %", output)
    assert share is not None, output
    pinches = [event for event in events if event["type"] == "pinch"]
    assert pinches, output
    missed = [p for p in pinches if p["verdict"] != "in_time"]
    estimates = [e for e in events if e["type"] == "estimate" and not e["final"]]
    compute = 1e3 * np.array([e["compute"] for e in estimates])
    delays: dict[str, list[float]] = {"first": [], "later": []}
    for before, e in zip([None, *estimates], estimates, strict=False):
        is_first = before is None or before["contact"] != e["contact"]
        delay = 1e3 * (e["waited"] + e["transport"] + e["compute"])
        delays["first" if is_first else "later"].append(round(delay, 3))
    p50, p99, longest = np.percentile(compute, [50, 99, 100]).round(3).tolist()
    return RealTime(
        machine=machine_name(),
        cores=os.cpu_count() or 1,
        load=os.getloadavg()[0],
        viewer=looked_at,
        closings=len(pinches),
        with_second=sum(p["offset"] is not None for p in pinches),
        in_force=len(pinches) - len(missed),
        in_force_share=1 - len(missed) / len(pinches),
        missed_offsets_ms=[round(1e3 * p["offset"], 2) for p in missed],
        first_pinch_ms=round(float(compute[0]), 3),
        compute_ms=(p50, p99, longest),
        first_ms=sorted(delays["first"]),
        later_ms=sorted(delays["later"]),
        core_share=float(share[1]) / 100,
    )


def main() -> dict[str, float]:
    """Measure everything and print the results. Return the ratios by name."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=20.0, help="length of each stream")
    parser.add_argument("--seed", type=int, default=5, help="random seed of the stream")
    parser.add_argument("--runs", type=int, default=1, help="real-time runs of each kind")
    parser.add_argument("--out", type=Path, help="JSON file for the figures of these runs")
    parser.add_argument("--disturbed", action="store_true", help="disturb the real-time runs")
    settings = parser.parse_args()
    with tempfile.TemporaryDirectory() as cache:
        os.environ["XDG_CACHE_HOME"] = cache
        folder = twin_model("paper-rig", 0)
        trained = load_model(folder)
        detector, model = trained.own_detector, trained.windows[0].model
        assert trained.network is not None
        anytime = trained.network
        predictors: tuple[Predictor, ...] = (
            anytime,
            PredictorLadder(trained.windows),
        )
        assert isinstance(model, SvmModel)
        twin = TwinStream("paper-rig", None, settings.seed)
        data = DeviceFilter().update(twin.read(round(settings.seconds * LAYOUT.rate)))
        quiet = Physical(LAYOUT, (0, 1))(data[: round(0.5 * LAYOUT.rate)])
        calibration = Calibration(
            tuple(VibrationCalibration(f, float(quiet[:, i].std())) for i, f in enumerate(Finger))
        )

        print(one_answer(anytime, settings.seed))
        for size, predictor in itertools.product((LONG, FRAME), predictors):
            pipeline = Pipeline(LAYOUT, detector, predictor, calibration, real_time=False)
            spent, pinches = replayed(pipeline, split(data, size))
            figures = pipeline.ledger.summary()
            print(
                f"{predictor.name}, blocks of {size} samples: "
                f"{settings.seconds / spent:.0f} x real time; block to estimate "
                f"p50 {1e6 * figures['compute_p50']:.0f} us, "
                f"p99 {1e6 * figures['compute_p99']:.0f} us, {len(pinches)} pinches"
            )
        naive = naive_seconds(data, pinches, detector, model)
        print(
            f"the same estimate from the whole closing so far: p50 {1e6 * naive:.0f} us, "
            f"{naive / figures['compute_p50']:.1f} x as long"
        )

        with disturbance() if settings.disturbed else nullcontext():
            runs = [
                real_time(settings.seconds, settings.seed + run, looked_at)
                for looked_at in (False, True)
                for run in range(settings.runs)
            ]
        for run in runs:
            print(f"{'page and a viewer' if run.viewer else 'no page'}: {run.words}")
        if settings.out is not None:
            tree = {
                "machine": machine_name(),
                "first_ms": sorted(delay for run in runs for delay in run.first_ms),
                "later_ms": sorted(delay for run in runs for delay in run.later_ms),
                "runs": [
                    {key: value for key, value in asdict(run).items() if key not in OF_ALL}
                    for run in runs
                ],
            }
            settings.out.write_text(json.dumps(tree, indent=1) + "\n")
    return {"estimate, against the whole closing so far": naive / figures["compute_p50"]}


if __name__ == "__main__":
    main()
