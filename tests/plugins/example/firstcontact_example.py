"""What another package may add: a policy, a hand, a source, an importer and an exporter."""

from __future__ import annotations

import json
from math import inf
from pathlib import Path
from typing import IO

import numpy as np

from firstcontact.core import Command, Contact, Dataset
from firstcontact.device.opening import SourceKind
from firstcontact.device.replay import ReplaySource
from firstcontact.grasp.hand import Hand, HandError, HandLimits
from firstcontact.grasp.policy import Policy
from firstcontact.recording.arrays import from_arrays
from firstcontact.recording.formats import Exporter, Importer


class Halfway(Policy):
    """Slows down at the first contact, but not as much as it could."""

    name = "halfway"
    title = "half as gentle"
    colour = "#123456"

    def touched(self, contact: Contact, first: bool) -> Command | None:
        """Slow down, once."""
        gentle = self.grip.gentle
        return Command((gentle.speed + self.grip.speed) / 2, gentle.force) if first else None


class DiaryHand(Hand):
    """Writes its commands into a file, which is its port."""

    name = "diary"
    limits = HandLimits(speed=0.2, force=10.0, rate=200.0, watchdog=inf)
    real = False
    rehearsal = "/dev/null"

    def __init__(self, port: str | None = None) -> None:
        self._path = Path(port or "/dev/null")
        self._file: IO[str] | None = None

    def send(self, command: Command) -> None:
        """Write it down."""
        if self._file is None:
            raise HandError("the diary is not open")
        print("close", command.speed, command.force, file=self._file)

    def release(self) -> None:
        """Write that down, too."""
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


TAPE = SourceKind(
    "tape",
    "tape:PATH for a recording by another name",
    lambda device, options: ReplaySource(Path(device.removeprefix("tape:")), options.speed),
    recorded=True,
)


def write(dataset: Dataset, path: Path) -> None:
    """Arrays as lists."""
    shortest = min(len(p.data) for p in dataset.pinches)
    tree = {
        "piezo": [p.piezo()[:shortest].tolist() for p in dataset.pinches],
        "shore_a": dataset.shore_a.tolist(),
        "sample_rate_hz": dataset.layout.rate,
        "piezo_unit": "V",
    }
    path.write_text(json.dumps(tree), encoding="utf-8")


def read(path: Path, rate: float | None) -> Dataset:
    """Lists as arrays."""
    tree = json.loads(path.read_text(encoding="utf-8"))
    return from_arrays(path, {name: np.array(value) for name, value in tree.items()})


IMPORTER = Importer("toy", "a .toy file", read, suffixes=(".toy",))
EXPORTER = Exporter("toy", write)
