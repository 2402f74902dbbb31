"""``firstcontact pretrain``: pre-train the network of the package."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from firstcontact.core.installation import require_modules


@dataclass(frozen=True)
class Pretrain:
    """Pre-train the network on simulated rigs.

    Intermediate files are kept, so the same command resumes a stopped run.
    """

    out: Path
    """Folder for the model; an existing model is replaced."""
    work: Path = Path("pretraining")
    """Folder for intermediate files, about 1.5 GB."""
    rigs: int = 6000
    """Number of simulated rigs to train on."""
    epochs: int = 45
    """Number of passes over the contacts of the rigs."""
    teachers: int = 4
    """Number of networks from whose mean the one of the model learns."""
    seed: int = 1
    """Random seed; on one machine it determines the weights."""
    workers: int = 0
    """Number of processes that simulate; 0 takes all cores."""

    def run(self) -> None:
        from firstcontact.core import ArgumentError
        from firstcontact.jobs import parallel, worker_count
        from firstcontact.models.training_plan import check_seed

        if self.rigs < 10 or min(self.epochs, self.teachers) < 1:
            raise ArgumentError(
                f"--rigs is {self.rigs}, --epochs {self.epochs} and --teachers {self.teachers}: "
                "give 10 or more rigs, and 1 or more of the others"
            )
        check_seed(self.seed)
        require_modules("cnn", "torch")
        from firstcontact_lab.pretraining.pretrain import Size, pretrain

        size = Size().resized(self.rigs, self.epochs, self.teachers)
        with parallel(worker_count(self.workers)) as runner:
            model = pretrain(self.out, self.work, size, self.seed, runner, print)
        print(f"{model.kind}: {self.out}")
