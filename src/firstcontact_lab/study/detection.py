"""Detection of contacts in pinches that the detector was not trained on (out of fold)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from firstcontact.contact import DETECTORS, make_detector
from firstcontact.contact.contacts import PinchDecisions
from firstcontact.core import ChannelKind, Contact, Dataset, InputError
from firstcontact.jobs import Runner
from firstcontact.models.splits import Split, by_session
from firstcontact_lab.study.detection_scores import judge_pinches
from firstcontact_lab.study.scores import random_folds

#: Number of folds: fewer than for an estimator, because a detector takes longer to train.
FOLDS = 3


def detection_splits(dataset: Dataset, seed: int) -> list[Split]:
    """Return splits that together test each pinch once.

    Only pinches of role ``train`` are used for training.
    """
    if len(dataset) < 2:
        return []
    sessions, test = dataset.sessions, dataset.test
    if len(np.unique(sessions)) > 1 and "" not in sessions:
        folds = _training_only(by_session(sessions, dataset.objects, seed, FOLDS), test)
        if all(len(fold.train) for fold in folds):
            return folds
    return _training_only(random_folds(np.zeros(len(dataset)), seed, FOLDS), test)


def _training_only(folds: Sequence[Split], test: NDArray[np.bool_]) -> list[Split]:
    return [replace(fold, train=fold.train[~test[fold.train]]) for fold in folds]


def judge(
    job: tuple[str, int], dataset: Dataset, splits: Sequence[Split], early: float
) -> list[PinchDecisions] | str:
    """Train a detector on one side of a split, and return its decisions on the other side.

    ``job`` is (name of the detector, index of the split). Labels may be up to ``early`` s too late.
    If the detector cannot be trained, return the reason as text.
    """
    name, split = job[0], splits[job[1]]
    detector = make_detector(name)
    if detector.learns:
        try:
            detector = detector.fit(dataset.take(split.train), early)
        except InputError as error:
            return str(error)
    return judge_pinches(detector, dataset.take(split.test))


def judge_detectors(
    dataset: Dataset, splits: Sequence[Split], early: float, runner: Runner
) -> tuple[dict[str, list[PinchDecisions]], dict[str, str]]:
    failed: dict[str, str] = {}
    for name, kind in DETECTORS.items():
        if kind.learns and not (splits and all(len(split.train) for split in splits)):
            failed[name] = "at least two pinches are needed: one for training, one for testing"
    for split in splits:
        if len(split.train):
            split.check(dataset.sessions, dataset.specimens)
    names = [name for name in DETECTORS if name not in failed]
    # The slowest detectors, which come last, begin: no worker waits for them at the end.
    jobs = [(name, place) for name in reversed(names) for place in range(len(splits))]
    answered = runner.map(judge, jobs, _vibration_only(dataset), splits, early)
    out: dict[str, dict[int, PinchDecisions]] = {name: {} for name in DETECTORS}
    for (name, place), answers in zip(jobs, answered, strict=True):
        if isinstance(answers, str):
            failed.setdefault(name, answers)
        else:
            out[name].update(zip(splits[place].test.tolist(), answers, strict=True))
    complete = {
        name: detections for name, detections in out.items() if splits and name not in failed
    }
    return {
        n: [detections[i] for i in range(len(dataset))] for n, detections in complete.items()
    }, failed


def _vibration_only(dataset: Dataset) -> Dataset:
    """Return the dataset without force channels, so that worker processes get less data."""
    columns = list(dataset.layout.columns(ChannelKind.VIBRATION))
    channels = tuple(replace(c, axes=1, axis=0) for c in dataset.layout.vibration)
    layout = replace(dataset.layout, channels=channels)
    return replace(
        dataset,
        pinches=tuple(
            replace(p, data=np.ascontiguousarray(p.data[:, columns]), layout=layout)
            for p in dataset.pinches
        ),
    )


def trigger_delays(
    dataset: Dataset, triggers: Sequence[Contact | None]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return (delays of triggers, delays of decisions) after the true contact, s.

    Both arrays have the shape (pinches,). They are NaN where a true or detected contact is missing.
    """
    rate = dataset.layout.rate
    out = np.full((2, len(dataset)), np.nan)
    for i, (pinch, trigger) in enumerate(zip(dataset.pinches, triggers, strict=True)):
        if trigger is not None and pinch.first is not None:
            truth = pinch.first.sample
            out[:, i] = (trigger.sample - truth) / rate, (trigger.decided - truth) / rate
    return out[0], out[1]
