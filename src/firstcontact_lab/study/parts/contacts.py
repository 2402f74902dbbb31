"""Contact detection by detectors that never saw the session they are judged on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from firstcontact.contact import (
    DETECTORS,
    WindowDecisions,
    closing_starts,
    count_starts,
    cut_closings,
    latch,
    make_detector,
    untrained_name,
)
from firstcontact.core import ByName, ChannelKind, Contact, Dataset, InputError, Runner
from firstcontact.models import (
    DetectionScores,
    Group,
    Split,
    by_session,
    judged,
    random_folds,
    score_decisions,
)
from firstcontact_lab.report.figures.delays import delay_figure
from firstcontact_lab.report.figures.detectors import detectors_figure
from firstcontact_lab.report.findings import Figure, PartResult
from firstcontact_lab.report.results.contact import ContactConditions, DetectionFolds, NotFound
from firstcontact_lab.report.results.study import SubjectResults
from firstcontact_lab.study._subject import Subject
from firstcontact_lab.study.settings import StudySettings

#: Where windows start when the detector asked for cannot be trained but labels know the contacts.
KNOWN = "known"
#: Folds: a detector needs fewer than an estimator, and takes longer to train.
FOLDS = 3


def contacts(subject: Subject, settings: StudySettings, runner: Runner) -> PartResult:
    """Find all first contacts out of fold, and score every detector against the truth.

    Sets ``subject.found``, by the detector of the settings. Detectors hear each pinch from
    where its closing starts. Where that detector cannot be trained, windows start at the
    contacts that the labels know or, if it finds more than those, at those of one that
    needs no training.
    """
    starts = closing_starts(subject.dataset)
    dataset = cut_closings(subject.dataset, starts)
    known = np.array([p.first is not None for p in dataset.pinches])
    splits = detection_splits(dataset, settings.seed)
    verdicts, failed = _judge(dataset, splits, settings.early, runner)
    if not any(DETECTORS[name].learns for name in verdicts):
        everyone = np.arange(len(dataset))
        splits = [Split("all", everyone[:0], everyone)]
        verdicts, _ = _judge(dataset, splits, settings.early, runner)
    fingers = dataset.layout.vibration_fingers
    start = settings.detector if settings.detector in verdicts else untrained_name()
    found = tuple(next(iter(latch(v, fingers, set())), None) for v in verdicts[start])
    missing = sum(contact is None for contact in found)
    not_found = NotFound(by=start, pinches=missing, of=len(dataset))
    left_out = []
    if start == settings.detector:
        subject.found = found
    else:
        title = DETECTORS[start].title
        where = f"where the {title} fires"
        if known.sum() >= len(dataset) - missing:
            start, where = KNOWN, "at the known contacts"
        else:
            subject.found = found
        failed[settings.detector] += f"; windows start {where}"
    left_out += [f"{DETECTORS[n].title} contact detector: {why}." for n, why in failed.items()]
    about = ContactConditions(
        windows_start_at=start,
        steady_state=count_starts(starts),
        folds=_told(splits) if known.any() else None,
        early_ms=1e3 * settings.early if known.any() else None,
        not_found=not_found,
    )
    scores: dict[str, DetectionScores] = {}
    figures: list[Figure] = []
    if known.any():
        for name, given in verdicts.items():
            step = DETECTORS[name].step
            scores[name] = score_decisions(given, dataset, step, settings.early)
        example = _example(dataset, found)
        figures.append(
            detectors_figure(
                subject.dataset.pinches[example],
                {name: given[example] for name, given in verdicts.items()},
                starts[example].sample,
                settings.early,
            )
        )
        figures.append(delay_figure(dataset, _firsts(dataset, verdicts), settings.early))
    else:
        left_out.append("Scores of contact detection: no pinch has a known first contact.")
    return PartResult(SubjectResults(contact=ByName(scores, about)), figures, left_out)


def detection_splits(dataset: Dataset, seed: int) -> list[Split]:
    """Folds over all pinches that learn from those with the role ``train`` only.

    Whole sessions are held out where sessions are known; else folds are drawn
    at random and say that they share sessions and specimens. None where there
    is a single pinch.
    """
    if len(dataset) < 2:
        return []
    sessions = dataset.sessions
    if len(np.unique(sessions)) > 1 and "" not in sessions:
        folds = by_session(sessions, dataset.objects, seed, FOLDS)
    else:
        folds = random_folds(np.zeros(len(dataset)), seed, FOLDS)
    return [replace(f, train=f.train[~dataset.test[f.train]]) for f in folds]


def judge(
    job: tuple[str, int], dataset: Dataset, splits: Sequence[Split], early: float
) -> list[WindowDecisions] | str:
    """Fit a detector where there is something to learn, and judge a split's other pinches.

    Answers with a sentence where it cannot learn from these pinches.

    Parameters
    ----------
    job
        Name of the detector, and which of the splits.
    dataset
        Pinches from where their closings start; only vibration channels are needed.
    splits
        What to learn from and what to judge.
    early
        How much earlier than its label a contact may be, s.
    """
    name, split = job[0], splits[job[1]]
    detector = make_detector(name)
    if detector.learns:
        try:
            detector = detector.fit(dataset.take(split.train), early)
        except InputError as error:
            return str(error)
    return judged(detector, dataset.take(split.test))


def _judge(
    dataset: Dataset, splits: Sequence[Split], early: float, runner: Runner
) -> tuple[dict[str, list[WindowDecisions]], dict[str, str]]:
    """Decisions of every detector, and why some have none."""
    failed: dict[str, str] = {}
    for name, kind in DETECTORS.items():
        if kind.learns and not (splits and len(splits[0].train)):
            failed[name] = "it takes two pinches or more to train it on some and judge it by others"
    for split in splits:
        if len(split.train):
            split.check(dataset.sessions, dataset.specimens)
    names = [name for name in DETECTORS if name not in failed]
    jobs = [(name, place) for place in range(len(splits)) for name in names]
    answered = runner.map(judge, jobs, _vibration_only(dataset), splits, early)
    out: dict[str, dict[int, WindowDecisions]] = {name: {} for name in DETECTORS}
    for (name, place), answers in zip(jobs, answered, strict=True):
        if isinstance(answers, str):
            failed.setdefault(name, answers)
        else:
            out[name].update(zip(splits[place].test.tolist(), answers, strict=True))
    whole = {name: found for name, found in out.items() if splits and name not in failed}
    return {n: [found[i] for i in range(len(dataset))] for n, found in whole.items()}, failed


def _vibration_only(dataset: Dataset) -> Dataset:
    """What travels to the workers: no force, no strips."""
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


def _told(splits: Sequence[Split]) -> DetectionFolds:
    shares = sorted(set().union(*(s.shares for s in splits)))
    held_out = "pinches" if Group.SESSION in shares else "sessions"
    return DetectionFolds(n=len(splits), held_out=held_out, shares=[str(s) for s in shares])


def _firsts(
    dataset: Dataset, verdicts: Mapping[str, Sequence[WindowDecisions]]
) -> dict[str, NDArray[np.float64]]:
    """Decision of the first trigger after the truth, ms; NaN where unknown or missed."""
    out = {}
    for name, given in verdicts.items():
        delays = np.full(len(dataset), np.nan)
        for i, (pinch, verdict) in enumerate(zip(dataset.pinches, given, strict=True)):
            found = latch(verdict, pinch.layout.vibration_fingers, set())
            if found and pinch.first is not None:
                delays[i] = 1e3 * (found[0].decided - pinch.first.sample) / pinch.layout.rate
        out[name] = delays
    return out


def _example(dataset: Dataset, found: Sequence[Contact | None]) -> int:
    """A pinch whose contact was found, the middle one."""
    able = [
        i
        for i, (p, c) in enumerate(zip(dataset.pinches, found, strict=True))
        if p.first is not None and c is not None
    ]
    able = able or [i for i, p in enumerate(dataset.pinches) if p.first is not None]
    return able[len(able) // 2]
