"""``firstcontact simulate``: recordings from the pinch twin."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from firstcontact.cli.cluster import where
from firstcontact.core import counted, require_modules


@dataclass(frozen=True)
class Simulate:
    """Make recordings of simulated pinches: five blocks and eight everyday objects."""

    out: Path
    """Folder for the recordings, one file a session; it must be empty or new."""
    condition: Literal["paper-rig", "everyday"] = "paper-rig"
    """Variation as in the published set-up, or as outside a lab."""
    pinches_per_block: int = 500
    """Number of pinches of each of the five blocks."""
    pinches_per_object: int = 50
    """Number of pinches of each of the eight unseen objects."""
    seed: int = 0
    """Random seed; the same seed writes the same bytes."""
    workers: int | None = None
    """Number of threads; all cores by default."""
    noise: Path | None = None
    """Recording of a real sensor at rest, whose noise replaces the modelled noise."""
    cluster: str | None = None
    """Dask cluster that does the work instead of this machine: tcp://HOST:PORT."""

    def run(self) -> None:
        """Simulate with a progress bar."""
        # fc.simulate also loads what it wrote, which may be larger than the memory.
        require_modules("twin", "numba")
        from firstcontact.twin import read_noise, simulate

        noise = None if self.noise is None else read_noise(self.noise)
        sizes = self.pinches_per_block, self.pinches_per_object
        with where(self.cluster):
            paths = simulate(self.out, self.condition, *sizes, self.seed, self.workers, True, noise)
        pinches = 5 * self.pinches_per_block + 8 * self.pinches_per_object
        print(f"{counted(pinches, 'pinch')} in {counted(len(paths), 'recording')}: {self.out}")
