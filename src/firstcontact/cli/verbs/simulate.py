"""Command ``firstcontact simulate``: recordings from the pinch twin."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from firstcontact.cli.options import Condition, Option, on_cluster
from firstcontact.core.text import counted


@dataclass(frozen=True)
class Simulate:
    """Make recordings of simulated pinches: five blocks and eight everyday objects."""

    out: Path
    """Folder for the recordings; it must be empty or new."""
    condition: Condition = "paper-rig"
    """Variation between pinches, as in the paper's set-up or everyday use."""
    pinches_per_block: int = 500
    """Number of pinches of each of the five blocks."""
    pinches_per_object: int = 50
    """Number of pinches of each of the eight unseen objects."""
    seed: Annotated[int, Option(group="simulated hand")] = 0
    """Random seed; the same seed writes the same bytes."""
    workers: Annotated[int, Option(group="machine")] = 0
    """Number of threads; 0 takes all cores."""
    noise: Annotated[Path | None, Option(group="simulated hand")] = None
    """Recording of a real sensor at rest; it replaces the modelled noise."""
    positions: Annotated[bool, Option(advanced=True, group="simulated hand")] = False
    """Let the hand report its positions, so that each pinch has a measured closing speed."""
    cluster: Annotated[str | None, Option(advanced=True, group="machine")] = None
    """Dask cluster that simulates the pinches: tcp://HOST:PORT."""

    def run(self) -> None:
        # The public function also loads what it wrote, which may be larger than the memory.
        from firstcontact.twin.noise import read_noise
        from firstcontact.twin.simulation import simulate_recordings

        noise = None if self.noise is None else read_noise(self.noise)
        sizes = self.pinches_per_block, self.pinches_per_object
        with on_cluster(self.cluster):
            paths = simulate_recordings(
                self.out,
                self.condition,
                *sizes,
                self.seed,
                self.workers or None,
                True,
                noise,
                self.positions,
            )
        pinches = 5 * self.pinches_per_block + 8 * self.pinches_per_object
        print(f"{counted(pinches, 'pinch')} in {counted(len(paths), 'recording')}: {self.out}")
