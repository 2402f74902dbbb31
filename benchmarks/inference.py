"""Inference time for single windows, p50 and p99, compared with scikit-learn and eager PyTorch.

The script trains an SVM and a CNN on simulated pinches of blocks, as many as the paper has. They
predict one window at a time on one thread: ``OMP_NUM_THREADS=1 python benchmarks/inference.py``.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from tempfile import TemporaryDirectory

from firstcontact.models import Task, make_estimator
from firstcontact.recording import load_dataset
from firstcontact.signal import contact_windows
from firstcontact.twin import simulate
from firstcontact_lab.study.parts.inference import time_inference


def main() -> dict[str, float]:
    """Simulate pinches, train the models and measure their time. Return the ratios."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--condition", default="everyday", help="condition of the twin")
    parser.add_argument("--pinches", type=int, default=450, help="pinches of each block")
    parser.add_argument("--calls", type=int, default=10_000)
    settings = parser.parse_args()

    with TemporaryDirectory() as folder:
        paths = simulate(Path(folder, "twin"), settings.condition, settings.pinches, 0, seed=0)
        dataset = load_dataset(paths)
    X, used = contact_windows(dataset, [p.first for p in dataset.pinches], 0.015)
    y, sessions = dataset.shore_a[used], dataset.sessions[used]
    print(f"{len(X)} windows of {X.shape[1]} samples, condition {settings.condition}")
    ratios = {}
    for name in ("svm", "cnn"):
        for task in Task:
            began = time.perf_counter()
            estimator = make_estimator(name, task, dataset.layout.rate)
            model = estimator.fit(X, y, sessions)
            seconds = time.perf_counter() - began
            spent = time_inference(model, X, estimator.reference(model, X, y), settings.calls)
            size = model.notes.get("support_vectors", model.notes.get("parameters"))
            print(
                f"{name} {task}: trained in {seconds:.1f} s ({size} support vectors or weights), "
                f"p50 {spent.p50:.0f} µs, p99 {spent.p99:.0f} µs, {spent.calls} calls; "
                f"{spent.reference} p50 {spent.reference_p50:.0f} µs, "
                f"p99 {spent.reference_p99:.0f} µs; {spent.speedup:.1f} times faster"
            )
            ratios[f"{name} {task}, against {spent.reference}"] = spent.speedup
    return ratios


if __name__ == "__main__":
    main()
