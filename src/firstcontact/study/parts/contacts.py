"""Contact detection by detectors that never saw the session they are judged on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.contact.closing_start import closing_starts, closings, counted
from firstcontact.contact.detector import Detector, Verdicts, latch
from firstcontact.contact.registry import make_detector
from firstcontact.contact.svm import SvmDetector
from firstcontact.core import Block, Contact, Dataset, InputError, Layout
from firstcontact.core.layout import ChannelKind
from firstcontact.learning.detection import score_detector
from firstcontact.learning.jobs import Runner
from firstcontact.learning.splits import Group, Split, by_session, random_folds
from firstcontact.report.figures.delays import delay_figure
from firstcontact.report.figures.detectors import detectors_figure
from firstcontact.report.findings import Figure, PartResult
from firstcontact.study.settings import Settings
from firstcontact.study.subject import Subject

#: The paper's two, in the order of the report; windows start where the last one says.
NAMES = ("three_sigma", "svm")
#: Where windows start when the SVM cannot be trained but labels know the contacts.
KNOWN = "known"
#: Folds: a detector needs fewer than an estimator, and takes longer to train.
FOLDS = 3


@dataclass(frozen=True, slots=True, eq=False)
class Judging:
    """Detectors to fit on some pinches and to hear about others.

    Parameters
    ----------
    name
        Of the detector.
    learn, ask
        Pinches from where their closings start; only piezo channels are needed.
    early
        How much earlier than its label a contact may be, s.
    """

    name: str
    learn: Dataset
    ask: Dataset
    early: float


class Replayed:
    """A detector that repeats the verdicts it is given, one pinch at each start.

    Scores over folds are scores of one dataset, so they are made in one go:
    this is the detector of all folds together.
    """

    def __init__(self, like: Detector, verdicts: Sequence[Verdicts]) -> None:
        self.name, self.duration, self.step = like.name, like.duration, like.step
        self._verdicts = iter(verdicts)

    def fit(self, dataset: Dataset) -> Replayed:
        """Nothing to learn."""
        return self

    def start(self, layout: Layout) -> None:
        """Move on to the next pinch."""
        self._now = next(self._verdicts)
        self._fingers = layout.piezo_fingers

    def judge(self, block: Block) -> Verdicts:
        """What was said of this pinch."""
        return self._now

    def update(self, block: Block) -> list[Contact]:
        """The contacts in what was said of this pinch."""
        return latch(self._now, self._fingers, set())


def contacts(subject: Subject, settings: Settings, runner: Runner) -> PartResult:
    """Find all first contacts out of fold, and score both detectors against the truth.

    Sets ``subject.found``. Detectors hear each pinch from where its closing starts.
    Where the SVM cannot be trained, windows start at the contacts that the labels
    know or, if it finds more than those, at those of the threshold, which needs no
    training.
    """
    starts = closing_starts(subject.dataset)
    dataset = closings(subject.dataset, starts)
    known = np.array([p.first is not None for p in dataset.pinches])
    left_out = []
    splits = detection_splits(dataset, settings.seed)
    why = ""
    try:
        verdicts = _judge(dataset, splits, NAMES, settings.early, runner)
        start = NAMES[-1]
    except InputError as error:
        everyone = np.arange(len(dataset))
        splits = [Split("all", everyone[:0], everyone)]
        verdicts = _judge(dataset, splits, NAMES[:1], settings.early, runner)
        start = NAMES[0]
        why = str(error)
    names = tuple(verdicts)
    fingers = dataset.layout.piezo_fingers
    found = tuple(next(iter(latch(v, fingers, set())), None) for v in verdicts[names[-1]])
    missing = sum(contact is None for contact in found)
    if start == NAMES[-1]:
        subject.found = found
    elif known.sum() >= len(dataset) - missing:
        start = KNOWN
        left_out.append(f"SVM contact detector: {why}; windows start at the known contacts.")
    else:
        subject.found = found
        left_out.append(f"SVM contact detector: {why}; windows start where the 3σ threshold fires.")
    tree: dict[str, Any] = {"windows_start_at": start, "steady_state": counted(starts)}
    figures: list[Figure] = []
    if known.any():
        for name in names:
            given = [v for v, k in zip(verdicts[name], known, strict=True) if k]
            scores = score_detector(
                Replayed(make_detector(name), given), dataset.take(known), settings.early
            )
            tree[name] = scores.to_json()
        tree["folds"] = _told(splits)
        tree["early_ms"] = 1e3 * settings.early
        example = _example(dataset, found)
        figures.append(
            detectors_figure(
                subject.dataset.pinches[example],
                {name: verdicts[name][example] for name in names},
                starts[example].sample,
                settings.early,
            )
        )
        figures.append(delay_figure(dataset, _firsts(dataset, verdicts, names), settings.early))
    else:
        left_out.append("Scores of contact detection: no pinch has a known first contact.")
    tree["not_found"] = {"by": names[-1], "pinches": missing, "of": len(dataset)}
    return PartResult({"contact": tree}, figures, left_out)


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


def judge(job: Judging) -> list[Verdicts]:
    """Fit where there is something to learn, and judge every pinch that is asked about."""
    detector: Detector = (
        SvmDetector(early=job.early) if job.name == "svm" else make_detector(job.name)
    )
    if job.name == "svm":
        detector = detector.fit(job.learn)
    out = []
    for pinch in job.ask.pinches:
        detector.start(pinch.layout)
        out.append(detector.judge(Block(pinch.data, pinch.first_sample)))
    return out


def _judge(
    dataset: Dataset, splits: Sequence[Split], names: Sequence[str], early: float, runner: Runner
) -> dict[str, list[Verdicts]]:
    if not splits:
        raise InputError("it takes two pinches or more to train it on some and judge it by others")
    slim = _piezo_only(dataset)
    jobs, places = [], []
    for split in splits:
        if len(split.train):
            split.check(dataset.sessions, dataset.specimens)
        for name in names:
            jobs.append(Judging(name, slim.take(split.train), slim.take(split.test), early))
            places.append((name, split.test))
    out: dict[str, dict[int, Verdicts]] = {name: {} for name in names}
    for (name, asked), answers in zip(places, runner.map(judge, jobs), strict=True):
        out[name].update(zip(asked.tolist(), answers, strict=True))
    return {name: [found[i] for i in range(len(dataset))] for name, found in out.items()}


def _piezo_only(dataset: Dataset) -> Dataset:
    """What travels to the workers: no force, no strips."""
    columns = list(dataset.layout.columns(ChannelKind.PIEZO))
    layout = replace(dataset.layout, channels=tuple(dataset.layout.channels[i] for i in columns))
    return replace(
        dataset,
        pinches=tuple(
            replace(p, data=np.ascontiguousarray(p.data[:, columns]), layout=layout)
            for p in dataset.pinches
        ),
    )


def _told(splits: Sequence[Split]) -> dict[str, Any]:
    shares = sorted(set().union(*(s.shares for s in splits)))
    held_out = "pinches" if Group.SESSION in shares else "sessions"
    return {"n": len(splits), "held_out": held_out, "shares": [str(s) for s in shares]}


def _firsts(
    dataset: Dataset, verdicts: dict[str, list[Verdicts]], names: Sequence[str]
) -> dict[str, NDArray[np.float64]]:
    """Decision of the first trigger after the truth, ms; NaN where unknown or missed."""
    out = {}
    for name in names:
        delays = np.full(len(dataset), np.nan)
        for i, (pinch, verdict) in enumerate(zip(dataset.pinches, verdicts[name], strict=True)):
            found = latch(verdict, pinch.layout.piezo_fingers, set())
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
