"""Command ``firstcontact train``: models and a detector, fitted to labelled pinches."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

from firstcontact.cli.options import Option, choice, on_cluster
from firstcontact.contact import DETECTORS
from firstcontact.models import ESTIMATORS

if TYPE_CHECKING:
    from firstcontact.core import Dataset
    from firstcontact.models import Model


@dataclass(frozen=True)
class Train:
    """Train stiffness models on pinches of role "train", and save them with a detector.

    If the pinches have a known Shore A, the network is conditioned on them, too.
    """

    data: Annotated[Path, Option(positional=True)]
    """A recording, or a folder of recordings."""
    out: Path
    """Folder for the model; an existing model is replaced."""
    estimator: Annotated[str | None, choice(ESTIMATORS, "model")] = None
    """Estimator to train; by default svm and the network."""
    detector_type: Annotated[str | None, choice(DETECTORS, "model")] = None
    """Detector to fit; by default the package's, if no fitted one is better."""
    detector_only: Annotated[bool, Option(advanced=True, group="model")] = False
    """Train only the contact detector. It needs true contacts, not Shore A."""
    task: Annotated[Literal["regression", "classification"], Option(group="model")] = "regression"
    """Task: predict any value of the label, or one of the values in training."""
    contacts: Annotated[Literal["detected", "known"], Option(advanced=True, group="data")] = (
        "detected"
    )
    """Contacts where signals start: from the detector, or the true ones."""
    window_ms: Annotated[tuple[float, ...], Option(group="model")] = (15.0,)
    """Lengths of windows after the contact, ms; one model for each."""
    level: Annotated[float, Option(group="training")] = 0.9
    """Coverage: share of intervals that should contain the true value."""
    seed: Annotated[int, Option(group="training")] = 0
    """Random seed of the folds, the search for settings and the training."""
    rate: Annotated[float | None, Option(advanced=True, group="data")] = None
    """Sampling rate of the model, Hz; by default 4936 with physical labels."""
    workers: Annotated[int, Option(advanced=True, group="training")] = 1
    """Number of processes; 0 takes all cores."""
    cluster: Annotated[str | None, Option(advanced=True, group="training")] = None
    """Dask cluster that trains the models: tcp://HOST:PORT."""

    #: Options whose parameter of the library has another name.
    options: ClassVar[dict[str, str]] = {"detector": "detector_type", "windows": "window_ms"}

    def run(self) -> None:
        from firstcontact.cli.output import print_losses
        from firstcontact.core.files import replacing_folder
        from firstcontact.models.model_file import check_replaceable
        from firstcontact.models.training_plan import check_windows
        from firstcontact.recording import load_dataset
        from firstcontact.recording.settings import given_rate

        windows = [1e-3 * ms for ms in self.window_ms]
        check_windows(windows)
        windows = [] if self.detector_only else windows
        former = check_replaceable(self.out, windows, network=not self.detector_only)
        if self.rate is not None:
            given_rate(self.rate)
        dataset = load_dataset(self.data)
        print_losses(dataset)
        with on_cluster(self.cluster), replacing_folder(self.out) as making:
            model = self._train(dataset)
            # Only the training shows whether the new model has a network: check again.
            check_replaceable(self.out, windows, network=model.network is not None)
            model.write(making)
        for line in model.notes:
            print(line)
        if model.prediction_times:
            print(f"wrote the model and the detector {model.own_detector.name} to {self.out}")
        else:
            print(f"wrote the detector {model.own_detector.name} to {self.out}")
        if former:
            print(f"replaced the former model in {self.out}")

    def _train(self, dataset: Dataset) -> Model:
        from firstcontact.models import train
        from firstcontact.models.training_runs import train_detector

        if self.detector_only:
            return train_detector(dataset, self.detector_type, rate=self.rate)
        return train(
            dataset,
            self.estimator,
            detector=self.detector_type,
            task=self.task,
            contacts=self.contacts,
            windows=[1e-3 * ms for ms in self.window_ms],
            level=self.level,
            rate=self.rate,
            seed=self.seed,
            workers=self.workers,
        )
