"""Speed of contact detection compared with real time and with one ``predict`` per window.

Two fingers arrive in blocks of 3 ms, as in live use. The naive form calls scikit-learn's
``predict`` for each window of each finger, with the same features and the same support vectors. Run
it with one thread:
``OMP_NUM_THREADS=1 python benchmarks/contact_detection.py``.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable

import numpy as np

from firstcontact.contact import Detector, SvmDetector, ThresholdDetector
from firstcontact.contact.contacts import contact_chain, judge_windows
from firstcontact.contact.training import window_features
from firstcontact.core import Block, Contact, Dataset, Finger, Label, Pinch, fingertip_layout
from firstcontact.signal import samples_in

LAYOUT = fingertip_layout()
STEP = samples_in(SvmDetector.step, LAYOUT.rate)


def closing(seed: int, samples: int = 1480) -> Pinch:
    """Return a synthetic closing: noise on both fingers, and damped ringing where one touches."""
    rng = np.random.default_rng(seed)
    data = rng.normal(16384, 40, (samples, 16))
    contact = int(rng.integers(500, 900))
    finger = Finger(seed % 2)
    age = np.arange(samples - contact)
    data[contact:, finger] += rng.uniform(500, 5000) * np.exp(-age / 30) * np.sin(0.2 * age + 0.2)
    truth = (Contact(finger, contact, contact),)
    return Pinch(np.rint(data).astype(np.int16), LAYOUT, Label(session=f"s{seed % 4}"), 0, truth)


def streamed(detector: Detector, data: np.ndarray) -> None:
    """Pass a closing's samples to the detector, in blocks of one step of its windows."""
    chain = contact_chain(detector, LAYOUT)
    for start in range(0, len(data), STEP):
        chain.take(Block(data[start : start + STEP], start))


def seconds(work: Callable[[], object], repeats: int = 3) -> float:
    """Return the shortest time of several runs of a function, s."""
    times = []
    for _ in range(repeats):
        begin = time.perf_counter()
        work()
        times.append(time.perf_counter() - begin)
    return min(times)


def naive_seconds_a_window(svm: SvmDetector, windows: int) -> float:
    """Return the time for ``windows`` windows, s, each with one ``predict`` of scikit-learn."""
    from sklearn.svm import SVC

    arrays = svm.to_arrays()
    rng = np.random.default_rng(0)
    support = arrays["support"]
    machine = SVC(C=1e9, gamma=float(arrays["gamma"]))
    machine.fit(support, arrays["weights"] > 0)
    x = rng.normal(size=(windows, 1, samples_in(svm.duration, LAYOUT.rate)))

    def one_by_one() -> None:
        for window in x:
            features = window_features(window, STEP)
            machine.predict((features - arrays["mean"]) / arrays["scale"])

    return seconds(one_by_one)


def main() -> dict[str, float]:
    """Measure the speeds and print the table. Return the ratios by name."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=20.0, help="length of the stream")
    parser.add_argument("--pinches", type=int, default=500, help="pinches scored offline")
    settings = parser.parse_args()
    training = Dataset(tuple(closing(i) for i in range(200)), "synthetic")
    begin = time.perf_counter()
    svm = SvmDetector().fit(training)
    print(f"svm trained on {len(training)} pinches in {time.perf_counter() - begin:.1f} s, "
          f"{len(svm.to_arrays()['weights'])} support vectors")  # fmt: skip
    quiet = np.random.default_rng(1).normal(16384, 40, (round(settings.seconds * LAYOUT.rate), 16))
    data = np.rint(quiet).astype(np.int16)
    pinches = [closing(1000 + i) for i in range(settings.pinches)]
    for detector in (ThresholdDetector(), svm):
        live = seconds(lambda d=detector: streamed(d, data))
        begin = time.perf_counter()
        for pinch in pinches:
            judge_windows(detector, LAYOUT, Block(pinch.data))
        offline = time.perf_counter() - begin
        print(
            f"{detector.name}: {settings.seconds / live:.0f} x real time in blocks of 3 ms; "
            f"{1e3 * offline / len(pinches):.2f} ms a pinch of 0.3 s offline"
        )
    windows = 2 * (len(data) // STEP)
    count = 2000
    naive = naive_seconds_a_window(svm, count) / count * windows
    ratios = [f"{naive / live:.1f} x live"]
    begin = time.perf_counter()
    judge_windows(svm, LAYOUT, Block(data))
    offline = time.perf_counter() - begin
    ratios.append(f"{naive / offline:.1f} x for the whole stream at once")
    print(
        f"naive predict per window would take {naive:.2f} s: svm is faster {' and '.join(ratios)}"
    )
    return {
        "blocks of 3 ms, against a predict per window": naive / live,
        "a whole stream, against a predict per window": naive / offline,
    }


if __name__ == "__main__":
    main()
