"""``firstcontact simulate``: recordings from the pinch twin."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from firstcontact.cli.cluster import where
from firstcontact.core import counted


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
        from firstcontact import simulate

        with where(self.cluster):
            data = simulate(
                self.out,
                condition=self.condition,
                pinches_per_block=self.pinches_per_block,
                pinches_per_object=self.pinches_per_object,
                seed=self.seed,
                workers=self.workers,
                noise=self.noise,
                progress=True,
            )
        sessions = counted(len(set(data.sessions.tolist())), "recording")
        print(f"{counted(len(data), 'pinch')} in {sessions}: {self.out}")
