"""``firstcontact train``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

import tyro

from firstcontact.cli.choices import one_of
from firstcontact.cli.cluster import where
from firstcontact.contact import DETECTORS
from firstcontact.models import ESTIMATORS, check_replaceable, folder_name, replaced

if TYPE_CHECKING:
    from firstcontact.core import Dataset
    from firstcontact.models import Model


@dataclass(frozen=True)
class Train:
    """Train stiffness models on pinches of role "train", and save them with a detector.

    If the pinches have a Shore A, the network is conditioned on them, too.
    """

    data: tyro.conf.Positional[Path]
    """A recording, or a folder of recordings."""
    out: Path
    """Folder for the model and the detector; an existing model is replaced."""
    model: Annotated[str, one_of(ESTIMATORS)] = ESTIMATORS.default
    """What learns."""
    detector: Annotated[str | None, one_of(DETECTORS)] = None
    """Contact detector; the default one if it can be fitted to these pinches."""
    detector_only: bool = False
    """Train the detector only; the pinches need known contacts, and no hardness."""
    task: Literal["regression", "classification"] = "regression"
    """Predict any Shore A, or one of the trained ones."""
    contacts: Literal["auto", "truth", "detected"] = "auto"
    """Start of windows: true or detected contacts; auto takes true ones if there are any."""
    window_ms: tuple[float, ...] = (15.0,)
    """Length of the window after the contact, ms; one model for each length."""
    level: float = 0.9
    """Share of intervals that should hold the truth."""
    seed: int = 0
    """Random seed of folds, search and training."""
    rate: float | None = None
    """Sampling rate to resample to, Hz; by default 4936 for Shore A labels, else as recorded."""
    workers: int = 1
    """Number of processes; 0 takes all cores."""
    cluster: str | None = None
    """Dask cluster that does the work instead of this machine: tcp://HOST:PORT."""

    #: Options whose parameter of the library has another name.
    options: ClassVar[dict[str, str]] = {"estimator": "model", "windows": "window_ms"}

    def run(self) -> None:
        """Train, save, and print the scores on held-out sessions."""
        from firstcontact.cli.losses import print_losses
        from firstcontact.core import replacing_folder
        from firstcontact.recording import check_rate, load_dataset

        names = [folder_name(ms) for ms in self.window_ms] if len(self.window_ms) > 1 else [""]
        names = [] if self.detector_only else names
        former = check_replaceable(self.out, names, anytime=not self.detector_only)
        if self.rate is not None:
            check_rate("--rate", self.rate)
        dataset = load_dataset(self.data)
        print_losses(dataset)
        with where(self.cluster), replacing_folder(self.out) as making:
            model = self._train(dataset)
            # The training decides whether there is an any-time model again.
            check_replaceable(self.out, names, anytime=model.network is not None)
            model.write(making)
        for line in model.notes:
            print(line)
        if model.moments:
            print(f"model: {self.out}")
        print(f"detector {model.own_detector.name}: {self.out}")
        if former:
            print(replaced(self.out))

    def _train(self, dataset: Dataset) -> Model:
        from firstcontact.models import train, train_detector

        if self.detector_only:
            return train_detector(dataset, self.detector, rate=self.rate)
        return train(
            dataset,
            self.model,
            detector=self.detector,
            task=self.task,
            contacts="known" if self.contacts == "truth" else self.contacts,
            windows=[1e-3 * ms for ms in self.window_ms],
            level=self.level,
            rate=self.rate,
            seed=self.seed,
            workers=self.workers,
        )
