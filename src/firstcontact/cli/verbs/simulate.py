"""``firstcontact simulate``: recordings from the pinch twin."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from firstcontact.cli.cluster import where
from firstcontact.core import counted, need


@dataclass(frozen=True)
class Simulate:
    """Make recordings of simulated pinches: five blocks and eight everyday objects."""

    out: Path
    """Folder for the recordings, one file a session; must be empty or new. It appears when all
    are written."""
    condition: Literal["paper-rig", "everyday"] = "paper-rig"
    """The published set-up, or pinches that vary as they do outside a lab."""
    pinches_per_block: int = 500
    """Pinches of each of the five blocks."""
    pinches_per_object: int = 50
    """Pinches of each of the eight unseen objects."""
    seed: int = 0
    """Same seed, same bytes."""
    workers: int | None = None
    """Threads; all cores by default. Does not change a byte."""
    noise: Path | None = None
    """A recording of a real sensor at rest: its noise lies under the pinches in place of the
    modelled electronics and hum."""
    cluster: str | None = None
    """A Dask cluster that does the work instead of this machine: tcp://HOST:PORT."""

    def run(self) -> None:
        """Simulate with a progress bar."""
        need("twin", "numba")
        from tqdm import tqdm

        from firstcontact.twin import check_set, read_noise, simulate

        noise = None if self.noise is None else read_noise(self.noise)
        asked = (self.condition, self.pinches_per_block, self.pinches_per_object, self.seed)
        check_set(self.out, *asked, self.workers)
        total = 5 * self.pinches_per_block + 8 * self.pinches_per_object
        with (
            where(self.cluster),
            tqdm(total=total, unit="pinch", desc=self.condition) as bar,
        ):
            paths = simulate(self.out, *asked, self.workers, bar.update, noise)
        print(f"{counted(total, 'pinch')} in {counted(len(paths), 'recording')}: {self.out}")
