"""From the signal of a touch to Shore A, with the library.

The contact detector and the stiffness model learn from the first sessions of a few
simulated pinches and are asked about the last one.

python examples/touch_to_stiffness.py
"""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from firstcontact.contact import SvmDetector, detect
from firstcontact.core import Contact, Dataset
from firstcontact.models import Svm, Task
from firstcontact.recording import load_dataset
from firstcontact.signal import contact_windows
from firstcontact.twin import simulate

DURATION = 0.015  # s after the contact


def main() -> None:
    """Simulate, learn, ask."""
    with TemporaryDirectory() as folder:
        simulate(
            Path(folder, "pinches"), "paper-rig", pinches_per_block=32, pinches_per_object=0, seed=1
        )
        dataset = load_dataset(Path(folder, "pinches"))
    asked = dataset.sessions == max(set(dataset.sessions))
    learning, unseen = dataset.take(~asked), dataset.take(asked)

    # Learn: contacts as the strips saw them.
    detector = SvmDetector().fit(learning)
    X, kept = contact_windows(learning, [p.first for p in learning.pinches], DURATION)
    estimator = Svm(Task.REGRESSION, learning.layout.rate)
    model = estimator.fit(X, learning.shore_a[kept], learning.sessions[kept])

    # Ask: contacts as the detector finds them, as in use.
    X, kept = contact_windows(unseen, firsts(detector, unseen), DURATION)
    told, true = model.predict(X), unseen.shore_a[kept]
    print(f"{len(learning)} pinches learnt from, {kept.sum()} of {len(unseen)} others estimated")
    for shore in np.unique(true):
        its = told[true == shore]
        print(f"{shore:4.0f} Shore A: told {its.mean():5.1f}, SD {its.std():4.1f}, n {len(its)}")
    print(f"RMSE {np.sqrt(np.mean((told - true) ** 2)):.1f} Shore A")


def firsts(detector: SvmDetector, dataset: Dataset) -> list[Contact | None]:
    """The first contact that a detector finds in each pinch."""
    return [next(iter(detect(detector, pinch)), None) for pinch in dataset.pinches]


if __name__ == "__main__":
    main()
