"""Your own detector in ten lines, compared with the published threshold.

python examples/own_detector.py
"""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from firstcontact.contact import Detector, ThresholdDetector, detect
from firstcontact.core import Dataset
from firstcontact.twin import simulate


class EnergyDetector(Detector):
    """Detector that fires when the newest samples are much louder than the steady state."""

    name = "energy"

    def fires(self, windows):
        """Return True for each window with a contact.

        A window is 20 ms of samples, of which the last 3 ms are new. ``windows`` has the shape
        (windows, fingers, samples). Its unit is the standard deviation of the steady state.
        """
        new = windows[:, :, -windows.shape[2] * 3 // 20 :]
        return np.mean(new**2, axis=2) > 6.0


def count_correct(detector: Detector, dataset: Dataset, within: float = 0.003) -> int:
    """Count first contacts on the right finger, at most ``within`` s from the strip's contact."""
    count = 0
    for pinch in dataset.pinches:
        contacts = detect(detector, pinch)
        if contacts and pinch.first and contacts[0].finger == pinch.first.finger:
            error = (contacts[0].sample - pinch.first.sample) / pinch.layout.rate
            count += abs(error) <= within
    return count


def main() -> None:
    """Compare the published threshold with EnergyDetector on a few pinches."""
    with TemporaryDirectory() as folder:
        dataset = simulate(
            Path(folder, "pinches"), pinches_per_block=8, pinches_per_object=0, seed=1
        )
    for detector in (ThresholdDetector(), EnergyDetector()):
        correct = count_correct(detector, dataset)
        print(f"{detector.name:12} {correct:3} of {len(dataset)} pinches right")


if __name__ == "__main__":
    main()
