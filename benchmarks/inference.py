"""Single-window inference, p50 and p99, beside scikit-learn and eager PyTorch in the same run.

Trains an SVM and a CNN on simulated block pinches of the published size and
asks them for one window at a time, on one thread:
``OMP_NUM_THREADS=1 python benchmarks/inference.py``.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from tempfile import TemporaryDirectory

from firstcontact.models import Task, make_estimator, time_inference
from firstcontact.recording import load_dataset
from firstcontact.signal import contact_windows
from firstcontact.twin import simulate


def main() -> None:
    """Simulate, train, time."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--condition", default="everyday", help="the one with more support vectors")
    parser.add_argument("--pinches", type=int, default=450, help="of each of the five blocks")
    parser.add_argument("--calls", type=int, default=10_000)
    asked = parser.parse_args()

    with TemporaryDirectory() as folder:
        paths = simulate(Path(folder, "twin"), asked.condition, asked.pinches, 0, seed=0)
        dataset = load_dataset(paths)
    X, kept = contact_windows(dataset, [p.first for p in dataset.pinches], 0.015)
    y, sessions = dataset.shore_a[kept], dataset.sessions[kept]
    print(f"{len(X)} windows of {X.shape[1]} samples, condition {asked.condition}")
    for name in ("svm", "cnn"):
        for task in Task:
            began = time.perf_counter()
            estimator = make_estimator(name, task, dataset.layout.rate)
            model = estimator.fit(X, y, sessions)
            seconds = time.perf_counter() - began
            spent = time_inference(model, X, estimator.reference(model, X, y), asked.calls)
            size = model.notes.get("support_vectors", model.notes.get("parameters"))
            print(
                f"{name} {task}: trained in {seconds:.1f} s ({size} support vectors or weights), "
                f"p50 {spent.p50:.0f} µs, p99 {spent.p99:.0f} µs, {spent.calls} calls; "
                f"{spent.reference} p50 {spent.reference_p50:.0f} µs, "
                f"p99 {spent.reference_p99:.0f} µs; {spent.speedup:.1f} times faster"
            )


if __name__ == "__main__":
    main()
