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
    """Learn stiffness models from the pinches of role "train"; save them with a detector.

    Where the pinches have a Shore A, an any-time model of their rig is saved beside them.
    """

    data: tyro.conf.Positional[Path]
    """A recording, or a folder of recordings."""
    out: Path
    """Folder for the model and the detector; a training that is in it is replaced whole."""
    model: Annotated[str, one_of(ESTIMATORS)] = ESTIMATORS.default
    """What learns."""
    detector: Annotated[str | None, one_of(DETECTORS)] = None
    """What finds contacts; left out: the usual one where it can learn from these pinches, else one
    that learns nothing."""
    detector_only: bool = False
    """Make the detector and no model: pinches need known contacts and no hardness."""
    task: Literal["regression", "classification"] = "regression"
    """Any Shore A, or one of those learned from."""
    contacts: Literal["auto", "truth", "detected"] = "auto"
    """Where windows start: known contacts, or found ones as live; auto: known if there are any."""
    window_ms: tuple[float, ...] = (15.0,)
    """Length of the window after the contact, ms; several make a model each, in folders as 03ms."""
    level: float = 0.9
    """Share of intervals that are to hold the truth."""
    seed: int = 0
    """Of the folds, the search and the training."""
    rate: float | None = None
    """Hz to resample the pinches to first; left out: that of the any-time model, 4936 Hz, where
    there are Shore A labels, and else as they were recorded."""
    workers: int = 1
    """Processes; 0 takes all cores."""
    cluster: str | None = None
    """A Dask cluster that does the work instead of this machine: tcp://HOST:PORT."""

    #: Options whose parameter of the library has another name.
    options: ClassVar[dict[str, str]] = {"estimator": "model", "windows": "window_ms"}

    def run(self) -> None:
        """Train, save, and print the scores on held-out sessions."""
        from firstcontact.cli.losses import warn_of
        from firstcontact.core import replacing_folder
        from firstcontact.recording import check_rate, load_dataset

        names = [folder_name(ms) for ms in self.window_ms] if len(self.window_ms) > 1 else [""]
        names = [] if self.detector_only else names
        former = check_replaceable(self.out, names, anytime=not self.detector_only)
        if self.rate is not None:
            check_rate("--rate", self.rate)
        dataset = load_dataset(self.data)
        warn_of(dataset)
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
