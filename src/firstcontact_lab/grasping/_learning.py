"""Detector and models that the study's hand uses, learned from other pinches of it."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from firstcontact.contact import Detector
from firstcontact.core import Dataset, InputError, Runner, Serial, to_tree
from firstcontact.models import RegressionScores
from firstcontact_lab.grasping.settings import GraspStudySettings
from firstcontact_lab.report.folder import MARK, fresh

if TYPE_CHECKING:
    from firstcontact.models import Alignment, FinalModel, LabelledWindows, WindowPredictor

#: The sessions learned from are named by the twin: "blocks-01" and on. Those closed in are not.
CONDITION = "paper-rig"
LEVEL = 0.9


@dataclass(frozen=True, slots=True)
class Learned:
    """Folder of the models, and their errors on held-out sessions."""

    folder: Path
    rmse: dict[str, float]
    width: dict[str, float]


@dataclass(frozen=True, slots=True, eq=False)
class Models:
    """Detector and estimators of the simulated hand."""

    detector: Detector
    stiffness: tuple[WindowPredictor, ...]


def learn(settings: GraspStudySettings, out: Path, runner: Runner) -> Learned:
    """Simulate pinches, learn a detector and a model for each length of window, and save them.

    Parameters
    ----------
    settings
        Size and seed.
    out
        Folder of the study; recordings and models go below it.
    runner
        Trains the models.

    Raises
    ------
    InputError
        Recordings or models are there that no study made.
    """
    from firstcontact.models import (
        Model,
        TrainingData,
        TrainingRecord,
        WindowPredictor,
        fit_detector,
        found_as_live,
    )
    from firstcontact.recording import load_dataset
    from firstcontact.twin import simulate

    models = out / "models"
    # Models come after recordings that bear the mark: without these, they are somebody's own.
    if models.exists() and not (out / "recordings" / MARK).exists():
        raise InputError(f"{models} was not made by a study: choose another --out, or move it away")
    recordings = fresh(out / "recordings", {"twin": CONDITION, "seed": settings.seed})
    if models.exists():
        shutil.rmtree(models)
    simulate(
        recordings / "pinches", CONDITION, settings.training, 0, settings.seed, settings.workers
    )
    dataset = load_dataset(recordings)
    detector = fit_detector(dataset, settings.detector)
    contacts = found_as_live(dataset, detector, settings.seed, runner)
    model, seed = settings.model, settings.seed
    learned = runner.map(_learned, settings.windows, dataset, contacts, model, seed)
    rmse, width, predictors = {}, {}, []
    for duration, (cut, saved) in zip(settings.windows, learned, strict=True):
        record = TrainingRecord(
            pinches=len(cut),
            split=saved.split,
            scores=to_tree(saved.scores),
            calibration=saved.conformal,
        )
        predictors.append(WindowPredictor(saved.model, saved.interval, record))
        held_out = saved.conformal.get("held_out") or {}
        assert isinstance(saved.scores, RegressionScores)
        rmse[f"{1e3 * duration:g}"] = saved.scores.rmse
        width[f"{1e3 * duration:g}"] = float(held_out.get("mean_width", 0.0))
    trained_on = TrainingData(
        source=dataset.source,
        pinches=len(dataset),
        sessions=tuple(sorted({str(s) for s in dataset.sessions})),
        contacts=contacts.how,
        seed=settings.seed,
    )
    data = {"source": dataset.source}
    Model(detector, tuple(predictors), trained_on, detector_data=data).save(models)
    return Learned(models, rmse, width)


def _learned(
    duration: float, dataset: Dataset, contacts: Alignment, model: str, seed: int
) -> tuple[LabelledWindows, FinalModel]:
    """Train a model for one window length. Return its training windows and the model."""
    from firstcontact.models import Task, labelled_windows, train_final_model

    cut = labelled_windows(dataset, contacts.contacts, duration, dataset.shore_a)
    return cut, train_final_model(cut, model, Task.REGRESSION, seed, LEVEL, Serial())


def loaded(folder: Path) -> Models:
    """Load the models that were trained and saved."""
    from firstcontact.models import load_model

    model = load_model(folder)
    return Models(model.own_detector, model.windows)
