"""Example plug-in package with one entry of each registry."""

from __future__ import annotations

import json
from dataclasses import dataclass
from math import inf
from pathlib import Path
from typing import IO

import numpy as np
from numpy.typing import NDArray

from firstcontact.contact import Detector
from firstcontact.core import Command, Contact, Dataset
from firstcontact.device import SourceKind
from firstcontact.device.replay import ReplaySource
from firstcontact.grasp import Hand, HandError, HandLimits, Policy
from firstcontact.models import Estimator, Spec, Task, WindowModel, training_spec
from firstcontact.recording import Exporter, Importer, from_arrays


class Halfway(Policy):
    """Policy that slows down at the first contact, halfway to the gentle command."""

    name = "halfway"
    title = "half as gentle"
    colour = "#123456"

    def touched(self, contact: Contact, first: bool) -> Command | None:
        """Slow down, once."""
        gentle = self.grip.gentle
        return Command((gentle.speed + self.grip.speed) / 2, gentle.force) if first else None


class DiaryHand(Hand):
    """Hand that writes its commands into a file, which is its port."""

    name = "diary"
    limits = HandLimits(speed=0.2, force=10.0, rate=200.0, watchdog=inf)
    real = False
    simulated_port = "/dev/null"

    def __init__(self, port: str | None = None) -> None:
        self._path = Path(port or "/dev/null")
        self._file: IO[str] | None = None

    def send(self, command: Command) -> None:
        """Write the command."""
        if self._file is None:
            raise HandError("the diary is not open")
        print("close", command.speed, command.force, file=self._file)

    def release(self) -> None:
        """Write the release."""
        if self._file is not None:
            print("release", file=self._file)

    def close(self) -> None:
        """Release, and close the file."""
        self.release()
        if self._file is not None:
            self._file.close()
        self._file = None

    def __enter__(self) -> DiaryHand:
        self._file = self._path.open("w", encoding="utf-8")
        return self


REEL = SourceKind(
    "reel",
    "reel:PATH for a recording by another name",
    lambda device, options: ReplaySource(Path(device.removeprefix("reel:")), options.speed),
    recorded=True,
)


def write(dataset: Dataset, path: Path) -> None:
    """Write a dataset as lists."""
    shortest = min(len(p.data) for p in dataset.pinches)
    tree = {
        "piezo": [p.vibration()[:shortest].tolist() for p in dataset.pinches],
        "shore_a": dataset.shore_a.tolist(),
        "sample_rate_hz": dataset.layout.rate,
        "piezo_unit": "V",
    }
    path.write_text(json.dumps(tree), encoding="utf-8")


def read(path: Path, rate: float | None) -> Dataset:
    """Read a dataset from lists."""
    tree = json.loads(path.read_text(encoding="utf-8"))
    return from_arrays(path, {name: np.array(value) for name, value in tree.items()})


IMPORTER = Importer("toy", "a .toy file", read, suffixes=(".toy",))
EXPORTER = Exporter("toy", write)


class EnergyDetector(Detector):
    """Detector that fires when the newest part is much louder than the steady state."""

    name = "energy"

    def fires(self, windows: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return True for each loud window."""
        new = windows[:, :, -windows.shape[2] * 3 // 20 :]
        return np.asarray(np.mean(new**2, axis=2) > 6.0)


class LoudnessModel(WindowModel):
    """Linear model of the logarithm of the RMS."""

    kind = "loudness"

    def __init__(self, spec: Spec, line: NDArray[np.float64]) -> None:
        self.spec, self.line = spec, line

    @property
    def notes(self) -> dict[str, float]:
        """Return the slope of the fitted line, for the model card."""
        return {"slope": float(self.line[0])}

    def outputs(self, X: NDArray[np.float32]) -> NDArray[np.float64]:
        """Return the line's value for each window."""
        loud = 0.5 * np.log((X.astype(np.float64) ** 2).mean(axis=(1, 2)))
        return np.asarray(np.polyval(self.line, loud)[:, None])

    def output(self, window: NDArray[np.float32]) -> NDArray[np.float64]:
        """Return the line's value for one window."""
        return np.asarray(self.outputs(window[None])[0])

    def to_arrays(self) -> dict[str, NDArray[np.float64]]:
        """Return slope and offset."""
        return {"line": self.line}

    @classmethod
    def from_arrays(cls, spec: Spec, arrays: dict[str, NDArray[np.float64]]) -> LoudnessModel:
        """Build the model from the arrays that :meth:`to_arrays` returned."""
        return cls(spec, arrays["line"])


@dataclass(frozen=True)
class Loudness(Estimator):
    """Linear model of the loudness."""

    name = "loudness"
    title = "Loudness alone"
    colour = "#654321"
    model = LoudnessModel
    tasks = (Task.REGRESSION,)

    def fit(
        self,
        X: NDArray[np.float32],
        y: NDArray[np.float64],
        groups: NDArray[np.str_] | None = None,
        seed: int = 0,
    ) -> LoudnessModel:
        """Fit a line to all windows."""
        spec = training_spec(self.task, self.rate, X, y, groups)
        loud = 0.5 * np.log((X.astype(np.float64) ** 2).mean(axis=(1, 2)))
        return LoudnessModel(spec, np.polyfit(loud, y, 1))
