"""Detector and models that the study's hand uses, learned from other pinches of it."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from firstcontact.contact import Detector
from firstcontact.core import Dataset, InputError
from firstcontact.grasp_study.settings import Settings
from firstcontact.learning.jobs import Runner
from firstcontact.live.pipeline import Answerer
from firstcontact.report.folder import MARK, fresh

#: The sessions learned from are named by the twin: "blocks-01" and on. Those closed in are not.
CONDITION = "paper-rig"
LEVEL = 0.9


@dataclass(frozen=True, slots=True)
class Learned:
    """Where the models are, and how far they were off on sessions held out."""

    folder: Path
    rmse: dict[str, float]
    width: dict[str, float]


@dataclass(frozen=True, slots=True, eq=False)
class _Lesson:
    recordings: Path
    folder: Path
    duration: float
    seed: int
    detector: str


def learn(settings: Settings, out: Path, runner: Runner) -> Learned:
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
    from firstcontact.contact.detector_file import save_detector, vouched
    from firstcontact.learning.alignment import fit_detector
    from firstcontact.recording import load_dataset
    from firstcontact.twin.simulate import simulate

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
    save_detector(fit_detector(dataset), models, {"source": dataset.source})
    lessons = [
        _Lesson(recordings, models / f"{1e3 * d:04.1f}ms", d, settings.seed, vouched(models))
        for d in settings.windows
    ]
    scores = runner.map(_train, lessons)
    names = [f"{1e3 * d:g}" for d in settings.windows]
    return Learned(
        models,
        {name: rmse for name, (rmse, _) in zip(names, scores, strict=True)},
        {name: width for name, (_, width) in zip(names, scores, strict=True)},
    )


def _train(lesson: _Lesson) -> tuple[float, float]:
    """One model, saved; its error on sessions held out and its intervals' mean width, Shore A."""
    from firstcontact.learning.alignment import fit_detector, found_as_live
    from firstcontact.learning.keeping import learn_to_keep
    from firstcontact.learning.training import examples
    from firstcontact.recording import load_dataset
    from firstcontact.stiffness import ESTIMATORS, Card, LearnedFrom, Task, save_model

    dataset: Dataset = load_dataset(lesson.recordings)
    contacts = found_as_live(dataset, fit_detector(dataset), lesson.seed)
    cut = examples(dataset, contacts.contacts, lesson.duration, dataset.shore_a)
    kept = learn_to_keep(cut, ESTIMATORS.default, Task.REGRESSION, lesson.seed, LEVEL)
    card = Card(
        data=LearnedFrom(
            source=dataset.source,
            pinches=len(cut),
            sessions=tuple(sorted({str(s) for s in cut.sessions})),
            contacts=contacts.how,
            seed=lesson.seed,
        ),
        split=kept.split,
        scores=kept.scores,
        interval=kept.interval,
        calibration=kept.calibration,
        detector=lesson.detector,
    )
    save_model(kept.model, lesson.folder, card)
    held_out = kept.calibration.get("held_out") or {}
    return float(kept.scores["rmse"]), float(held_out.get("mean_width", 0.0))


@lru_cache(maxsize=1)
def loaded(folder: Path) -> tuple[Detector, tuple[Answerer, ...]]:
    """What was learned, once a process."""
    from firstcontact.contact.detector_file import load_detector
    from firstcontact.stiffness import load_interval, load_model
    from firstcontact.stiffness.model_file import model_folders

    answerers = tuple(Answerer(load_model(f), load_interval(f)) for f in model_folders(folder))
    return load_detector(folder), answerers
