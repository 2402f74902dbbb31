"""A detector of your own in ten lines, beside the published threshold.

python examples/own_detector.py
"""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from firstcontact.contact import Detector, ThresholdDetector, WindowDetector, detect
from firstcontact.core import Dataset
from firstcontact.recording import load_dataset
from firstcontact.twin import simulate


class EnergyDetector(WindowDetector):
    """Fires when the newest part is much louder than the steady state."""

    name = "energy"

    def fires(self, windows):
        """Judge windows in sigmas of the steady state, (windows, fingers, samples)."""
        new = windows[:, :, -windows.shape[2] * 3 // 20 :]
        return np.mean(new**2, axis=2) > 6.0


def right(detector: Detector, dataset: Dataset, within: float = 0.003) -> int:
    """Pinches whose first contact has the right finger and is near the strip's, s."""
    count = 0
    for pinch in dataset.pinches:
        found = detect(detector, pinch)
        if found and pinch.first and found[0].finger == pinch.first.finger:
            late = (found[0].sample - pinch.first.sample) / pinch.layout.rate
            count += abs(late) <= within
    return count


def main() -> None:
    """Compare the two on a few pinches."""
    with TemporaryDirectory() as folder:
        simulate(
            Path(folder, "pinches"), "paper-rig", pinches_per_block=8, pinches_per_object=0, seed=1
        )
        dataset = load_dataset(Path(folder, "pinches"))
    for detector in (ThresholdDetector(), EnergyDetector()):
        print(f"{detector.name:12} {right(detector, dataset):3} of {len(dataset)} pinches right")


if __name__ == "__main__":
    main()
