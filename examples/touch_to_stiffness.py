"""Stiffness from the signal of a touch, with the library.

A few pinches are simulated in several sessions. The contact detector and the stiffness model learn
from all sessions but the last, and predict for the last session.

python examples/touch_to_stiffness.py
"""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from firstcontact.contact import SvmDetector, detect
from firstcontact.core import Contact, Dataset
from firstcontact.models import Task, make_estimator
from firstcontact.signal import contact_windows
from firstcontact.twin import simulate

DURATION = 0.015  # s after the contact


def main() -> None:
    """Simulate pinches, train on the first sessions, and predict for the last session."""
    with TemporaryDirectory() as folder:
        dataset = simulate(
            Path(folder, "pinches"), pinches_per_block=32, pinches_per_object=0, seed=1
        )
    held_out = dataset.sessions == max(set(dataset.sessions))
    learning, unseen = dataset.take(~held_out), dataset.take(held_out)

    # Train with the contacts of the strips.
    detector = SvmDetector().fit(learning)
    X, used = contact_windows(learning, [p.first for p in learning.pinches], DURATION)
    estimator = make_estimator("svm", Task.REGRESSION, learning.layout.rate)
    model = estimator.fit(X, learning.shore_a[used], learning.sessions[used])

    # Predict from the detector's contacts, as in live use.
    X, used = contact_windows(unseen, firsts(detector, unseen), DURATION)
    predicted, true = model.predict(X), unseen.shore_a[used]
    print(f"trained on {len(learning)} pinches, predicted {used.sum()} of {len(unseen)} others")
    for shore in np.unique(true):
        values = predicted[true == shore]
        print(
            f"{shore:4.0f} Shore A: {values.mean():5.1f}, SD {values.std():4.1f}, n {len(values)}"
        )
    print(f"RMSE {np.sqrt(np.mean((predicted - true) ** 2)):.1f} Shore A")


def firsts(detector: SvmDetector, dataset: Dataset) -> list[Contact | None]:
    """Return the first contact that a detector finds in each pinch."""
    return [next(iter(detect(detector, pinch)), None) for pinch in dataset.pinches]


if __name__ == "__main__":
    main()
