"""Benchmark of a regressor on recordings."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Contact, Dataset, InputError, Record, Runner, counted
from firstcontact.models import (
    LabelledTouches,
    Predictions,
    Split,
    by_session,
    choose_detector,
    detect_alignment,
    pretrained,
)
from firstcontact.recording import check_rate, load_dataset
from firstcontact.signal import resample_dataset
from firstcontact_lab.study._comparison import NETWORK
from firstcontact_lab.study._entrants import Entrant, fit_predictor
from firstcontact_lab.study._subject import Subject
from firstcontact_lab.study.benchmark import competitors
from firstcontact_lab.study.parts.objects import why_not_unseen
from firstcontact_lab.study.scores import (
    AnytimeScores,
    anytime_scores,
    join_by_time,
    predictions_by_time,
)
from firstcontact_lab.study.splits import learns_one_value

Names = NDArray[np.str_]


class RecordedScores(Record, frozen=True, kw_only=True):
    """Scores of one group of recorded pinches, by competitor."""

    learned: float
    folds: int
    cluster: str
    clusters: int
    scores: dict[str, AnytimeScores]


class RecordedData(Record, frozen=True, kw_only=True):
    """Recordings of a benchmark and the scores on them."""

    path: str
    source: str
    pinches: int
    unused: int
    too_short: int
    levels: list[float]
    contacts: str
    detector: str = ""
    held_out: RecordedScores
    objects: RecordedScores | None = None
    left_out: str = ""


def benchmark_recordings(
    name: str,
    path: Path,
    seed: int,
    runner: Runner,
    say: Callable[[str], object] = lambda line: None,
) -> RecordedData:
    """Score a regressor, the default estimator and the network on the same folds."""
    entrants = [e for e in competitors(name) if e is not NETWORK[-1]]
    dataset = _load(path, say)
    contacts, how, chosen = _contacts(dataset, seed, runner)
    labelled = LabelledTouches.cut(dataset, contacts)
    labelled_touches = labelled.take(labelled.touches.answerable)
    test = dataset.test[labelled_touches.rows]
    learn, ask = np.flatnonzero(~test), np.flatnonzero(test)
    cluster, groups = _groups(dataset, labelled_touches, learn, path)
    folds = [
        replace(fold, train=learn[fold.train], test=learn[fold.test])
        for fold in by_session(groups[learn], labelled_touches.shore_a[learn], seed)
    ]
    if learns_one_value(folds, labelled_touches.shore_a):
        raise InputError(
            f"{path}: if some {cluster}s are held out, fewer than two Shore A levels are left for "
            f"training: record each level in several {cluster}s, or more levels"
        )
    say(f"{path}: {counted(len(learn), 'pinch')}, {counted(len(folds), 'fold')} by {cluster}")
    reason = why_not_unseen(Subject("recordings", dataset)) if dataset.test.any() else ""
    if dataset.test.any() and not (reason or len(ask)):
        reason = "Unseen objects: no contact was found in them."
    objects = None
    try:
        held_out = _scores(entrants, labelled_touches, folds, groups, groups, cluster, seed, runner)
        if len(ask) and not reason:
            split = Split("unseen objects", learn, ask)
            clusters = labelled_touches.clusters
            objects = _scores(
                entrants, labelled_touches, [split], groups, clusters, "specimen", seed, runner
            )
    except InputError as error:
        raise InputError(f"{path}: {error}") from error
    return RecordedData(
        path=str(path),
        source=dataset.source,
        pinches=len(dataset),
        unused=len(dataset) - len(labelled),
        too_short=len(labelled) - len(labelled_touches),
        levels=[float(level) for level in np.unique(labelled_touches.shore_a[learn])],
        contacts=how,
        detector=chosen,
        held_out=held_out,
        objects=objects,
        left_out=reason,
    )


def _load(path: Path, say: Callable[[str], object]) -> Dataset:
    """Return the pinches of recordings, resampled to the network's rate."""
    dataset = load_dataset(path)
    for sentence in dataset.losses:
        say(f"warning: {sentence}")
    if dataset.test.all():
        raise InputError(f'{path}: all pinches have role "test": record training pinches')
    if not np.isfinite(dataset.shore_a[~dataset.test]).any():
        raise InputError(
            f"{path}: no training pinch has a Shore A: record with --shore-a, or import with a "
            "column 'shore_a'"
        )
    check_rate(f"{path}: the rate", dataset.layout.rate)
    resampled = resample_dataset(dataset, pretrained().rate)
    if resampled is not dataset:
        say(resampled.notes[-1])
    return resampled


def _contacts(
    dataset: Dataset, seed: int, runner: Runner
) -> tuple[Sequence[Contact | None], str, str]:
    """Return the first contact of each pinch, how it was detected, and by which detector."""
    contacts: list[Contact | None] = [None] * len(dataset)
    learn = dataset.take(~dataset.test)
    detector, alignment, reason = choose_detector(
        learn, name=None, is_known=False, seed=seed, runner=runner
    )
    parts = [(~dataset.test, alignment.contacts)]
    if dataset.test.any():
        parts.append(
            (dataset.test, detect_alignment(dataset.take(dataset.test), detector).contacts)
        )
    for mask, part in parts:
        for place, contact in zip(np.flatnonzero(mask), part, strict=True):
            contacts[place] = contact
    return contacts, alignment.how, reason


def _groups(
    dataset: Dataset, labelled: LabelledTouches, learn: NDArray[np.intp], path: Path
) -> tuple[str, Names]:
    """Return "session" or "specimen", and the session or specimen of each pinch."""
    if labelled.take(learn).named_sessions is not None:
        return "session", labelled.sessions
    specimens = [dataset.pinches[place].label.specimen for place in labelled.rows[learn]]
    if len(set(specimens)) < 2 or "" in specimens:
        raise InputError(
            f"{path}: contacts with a Shore A are all of one session and one specimen (or have no "
            "names), so none can be held out: record two sessions or more"
        )
    return "specimen", labelled.specimens


def _scores(
    entrants: Sequence[Entrant],
    labelled: LabelledTouches,
    splits: Sequence[Split],
    groups: Names,
    clusters: Names,
    cluster: str,
    seed: int,
    runner: Runner,
) -> RecordedScores:
    """Return the scores of all competitors on the test sides of the same splits."""
    trainings = [(entrant, split) for entrant in entrants for split in splits]
    answers = iter(runner.map(_predict, trainings, labelled, groups, seed))
    order = np.concatenate([split.test for split in splits])
    scores = {}
    for entrant in entrants:
        parts = [next(answers) for _ in splits]
        scores[entrant.name] = anytime_scores(
            join_by_time(parts), labelled.shore_a[order], clusters[order], seed
        )
    return RecordedScores(
        learned=float(np.mean([len(split.train) for split in splits])),
        folds=len(splits),
        cluster=cluster,
        clusters=len(np.unique(clusters[order])),
        scores=scores,
    )


def _predict(
    training: tuple[Entrant, Split], labelled: LabelledTouches, groups: Names, seed: int
) -> dict[int, Predictions]:
    """Fit a competitor to the training side of a split. Return predictions of the test side."""
    entrant, split = training
    train, test = labelled.take(split.train), labelled.take(split.test)
    model = fit_predictor(entrant, train.touches, train.shore_a, groups[split.train], seed)
    return predictions_by_time(model, test.touches)
