"""The live pipeline: how much faster than real time, and how late an estimate is.

The twin's running hand (60 s, closing some 30 times) is replayed through the pipeline in
blocks of 0.1 s and of 5 samples, as a device sends them. Beside it, what one would write
without streaming objects: detect and cut anew in all of the closing so far, and ask
scikit-learn's ``predict``. Then the same hand runs in real time as a
device on a pseudo terminal, and the ledger tells the times. Run with one thread:
``OMP_NUM_THREADS=1 python benchmarks/live.py``.
"""

from __future__ import annotations

import argparse
import os
import tempfile
import time
from pathlib import Path

import numpy as np

from firstcontact.cli.twin_model import twin_model
from firstcontact.contact import Detector, detect
from firstcontact.contact.detector_file import load_detector
from firstcontact.core import (
    Block,
    Calibration,
    Dataset,
    Finger,
    Physical,
    PiezoCalibration,
    Pinch,
    fingertip_layout,
)
from firstcontact.device.noise_floor import measure_noise
from firstcontact.device.twin_source import TwinSource
from firstcontact.live.events import PinchDone
from firstcontact.live.pipeline import Answerer, Pipeline
from firstcontact.live.session import Session
from firstcontact.live.summary import ledger_lines
from firstcontact.signal import contact_windows
from firstcontact.stiffness import load_interval, load_model
from firstcontact.stiffness.svm import machine_of
from firstcontact.stiffness.svm_model import SvmModel, shape_and_level
from firstcontact.twin.filter import DeviceFilter
from firstcontact.twin.stream import TwinStream

LAYOUT = fingertip_layout()
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


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=60.0, help="of each stream")
    parser.add_argument("--seed", type=int, default=5, help="of the stream")
    settings = parser.parse_args()
    with tempfile.TemporaryDirectory() as cache:
        os.environ["XDG_CACHE_HOME"] = cache
        folder = twin_model("paper-rig", 0)
        detector, model = load_detector(folder), load_model(folder)
        answerers = [Answerer(model, load_interval(Path(folder)))]
    assert isinstance(model, SvmModel)
    twin = TwinStream("paper-rig", None, settings.seed)
    data = DeviceFilter().update(twin.read(round(settings.seconds * LAYOUT.rate)))
    rest = Physical(LAYOUT, (0, 1))(data[: round(0.5 * LAYOUT.rate)])
    calibration = Calibration(
        tuple(PiezoCalibration(f, float(rest[:, i].std())) for i, f in enumerate(Finger))
    )

    for size in (LONG, FRAME):
        pipeline = Pipeline(LAYOUT, detector, answerers, calibration)
        spent, done = replayed(pipeline, blocks_of(data, size))
        figures = pipeline.ledger.summary()
        print(
            f"blocks of {size} samples: {settings.seconds / spent:.0f} x real time; block to "
            f"estimate p50 {1e6 * figures['compute_p50']:.0f} us, "
            f"p99 {1e6 * figures['compute_p99']:.0f} us, {len(done)} pinches"
        )
    naive = naive_seconds(data, done, detector, model)
    print(
        f"the same answer made anew from the closing so far: p50 {1e6 * naive:.0f} us, "
        f"{naive / figures['compute_p50']:.1f} x as long"
    )

    print(f"\nin real time, {settings.seconds:g} s over a pseudo terminal:")
    with TwinSource(seed=settings.seed) as source:
        session = Session(
            source,
            Pipeline(LAYOUT, detector, answerers, measure_noise(source, 1.0)),
        )
        before, cpu = source.health.samples, time.process_time()
        session.run(seconds=settings.seconds)
        cpu = time.process_time() - cpu
        health = source.health
        samples = (health.samples - before) / LAYOUT.rate
    for line in ledger_lines(session.pipeline.ledger.summary(), samples, cpu):
        print(line)
    print(f"{health.lost_samples} samples lost of {health.samples}")


if __name__ == "__main__":
    main()
