"""Evaluation of a model on labelled pinches, grouped by overlap with its training."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from firstcontact.contact import Detector
from firstcontact.core import Dataset, InputError, Progress, counted, is_same_rate, progress_steps
from firstcontact.models._alignment import Alignment, found, known
from firstcontact.models._anytime_scores import anytime_scores, predictions_by_time
from firstcontact.models._final_model import Target, covered, score
from firstcontact.models._metrics import per_object
from firstcontact.models._model import Model, require_dataset
from firstcontact.models._predictors import NetworkPredictor, WindowPredictor
from firstcontact.models._scores import Ends, SpecimenErrors, TaskScores
from firstcontact.models._train import known_contacts
from firstcontact.models._train_overlap import SEEN, TrainOverlap, train_overlap
from firstcontact.models._training import LabelledTouches, labelled_windows
from firstcontact.signal import resample_dataset

T = TypeVar("T")


@dataclass(frozen=True, slots=True, kw_only=True)
class GroupScores:
    """Scores of one predictor on pinches that have the same relation to its training.

    Parameters
    ----------
    title
        That relation, as "not seen in training".
    predictor
        Name of the estimator, or of the network.
    n
        Number of pinches.
    rmse, coverage, width, out_of_range
        By elapsed time, s: error in Shore A (or ranks), share of truths in the interval, mean
        width of the interval, and share of contacts that are marked out of range. Empty where the
        model has none.
    intervals
        90 % intervals of these scores over specimens, by score and elapsed time.
    constant
        Error of always predicting the mean of these pinches; None for classes.
    window
        All scores of a window model; None for the network.
    objects
        Errors of each specimen of a window model.
    level
        Level of the model's intervals; None without intervals.
    """

    title: str
    predictor: str
    n: int
    rmse: Mapping[float, float] = field(default_factory=dict)
    coverage: Mapping[float, float] = field(default_factory=dict)
    width: Mapping[float, float] = field(default_factory=dict)
    out_of_range: Mapping[float, float] = field(default_factory=dict)
    intervals: Mapping[str, Mapping[float, Ends]] = field(default_factory=dict)
    constant: float | None = None
    window: TaskScores | None = None
    objects: Mapping[str, SpecimenErrors] = field(default_factory=dict)
    level: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Evaluation:
    """Scores of one predictor of a model.

    Parameters
    ----------
    predictor
        Name of the estimator, or of the network.
    target
        Label that is predicted.
    contacts
        How the contacts were found, in words.
    scored, left_out
        Number of pinches that were scored, and of all others: without a contact, a label or a
        whole window, of a class that the model does not know, or for the network without enough
        signal before the second contact. Windows may hold the second contact, as in the paper.
    warnings
        Sentences about pinches that the model was trained on.
    groups
        Scores, pinches that were not seen in training first.
    duration
        Length of the window, s; None for the network.
    """

    predictor: str
    target: Target
    contacts: str
    scored: int
    left_out: int
    warnings: tuple[str, ...]
    groups: tuple[GroupScores, ...]
    duration: float | None = None

    @property
    def when(self) -> str:
        """Elapsed time of the predictions, in words."""
        return "at any time" if self.duration is None else f"{1e3 * self.duration:g} ms"

    @property
    def rmse(self) -> Mapping[float, float]:
        """Root mean square error by elapsed time, s; empty if all pinches are of the training."""
        return self._unseen.rmse if self._unseen else {}

    @property
    def coverage(self) -> Mapping[float, float]:
        """Share of truths in the interval by elapsed time, s, as :attr:`rmse`."""
        return self._unseen.coverage if self._unseen else {}

    @property
    def width(self) -> Mapping[float, float]:
        """Mean width of the interval by elapsed time, s, as :attr:`rmse`."""
        return self._unseen.width if self._unseen else {}

    @property
    def _unseen(self) -> GroupScores | None:
        """First group that is not of the training itself."""
        return next((group for group in self.groups if group.title != SEEN), None)


def evaluate(
    model: Model,
    data: Dataset,
    *,
    contacts: str = "auto",
    detector: Detector | None = None,
    progress: Progress = None,
) -> tuple[Evaluation, ...]:
    """Score every predictor of a model on labelled pinches.

    Parameters
    ----------
    model
        What is scored.
    data
        Pinches as they were loaded; they are resampled to the model's rate where theirs differs.
    contacts
        Windows start at "known" contacts or at "detected" ones; "auto" takes known ones where
        there are any.
    detector
        Contact detector in place of the model's own.
    progress
        True shows a bar; a function is called with 1 for each predictor that is scored.

    Returns
    -------
    tuple of Evaluation
        The network first, then window models, the shortest window first.

    Raises
    ------
    InputError
        No pinch can be scored, or the model holds a detector only.

    Examples
    --------
    >>> import firstcontact as fc
    >>> data = fc.load("recordings")
    >>> model = fc.adapt()  # the network of the package, which knows no rig
    >>> for evaluation in fc.evaluate(model, data):
    ...     print(evaluation.scored, "pinches scored at", *evaluation.rmse, "s")
    59 pinches scored at 0.002 0.003 0.005 0.008 0.015 s
    >>> isinstance(evaluation, fc.Evaluation), isinstance(evaluation.groups[0], fc.GroupScores)
    (True, True)
    """
    if not model.moments:
        raise InputError("it holds a detector only: train with an estimator", parameter="model")
    require_dataset(data)
    aligned: dict[float, tuple[Dataset, Alignment]] = {}

    def at(rate: float) -> tuple[Dataset, Alignment]:
        if rate not in aligned:
            dataset = data if is_same_rate(data.layout.rate, rate) else resample_dataset(data, rate)
            if known_contacts(contacts, dataset):
                aligned[rate] = dataset, known(dataset)
            else:
                aligned[rate] = dataset, found(dataset, detector or model.own_detector)
        return aligned[rate]

    out = []
    overlap = train_overlap(data, model.trained_on, model.digests)
    with progress_steps(progress, len(model.predictors), "model", "scoring") as step:
        if model.network is not None:
            out.append(_of_network(model.network, overlap, *at(model.network.rate)))
            step(1)
        for window in model.windows:
            target = model.trained_on.target
            out.append(_of_window(window, target, overlap, *at(window.rate)))
            step(1)
    return tuple(out)


def _of_network(
    predictor: NetworkPredictor, overlap: TrainOverlap, dataset: Dataset, aligned: Alignment
) -> Evaluation:
    model = predictor.model
    labelled = LabelledTouches.of(dataset, aligned.contacts)
    labelled = labelled.take(labelled.touches.answerable)
    if not len(labelled):
        raise InputError(
            f"none of {len(dataset)} pinches has a contact ({aligned.how}), a Shore A, and "
            f"{model.shortest} samples before its second contact",
            parameter="data",
        )
    groups = []
    for title, members in overlap.groups().items():
        part = labelled.take(members[labelled.which])
        if len(part):
            answers = predictions_by_time(model, part.touches)
            scores = anytime_scores(answers, part.shore_a, part.clusters, 0)
            groups.append(
                GroupScores(
                    title=title,
                    predictor=model.kind,
                    n=len(part),
                    rmse=_by_seconds(scores.rmse),
                    coverage=_by_seconds(scores.coverage),
                    width=_by_seconds(scores.width),
                    out_of_range=_by_seconds(scores.strange),
                    intervals={k: _by_seconds(v) for k, v in scores.intervals.items()},
                    constant=float(part.shore_a.std()),
                    level=model.level,
                )
            )
    return Evaluation(
        predictor=model.kind,
        target="shore_a",
        contacts=aligned.how,
        scored=len(labelled),
        left_out=len(dataset) - len(labelled),
        warnings=tuple(overlap.warnings(labelled.which)),
        groups=tuple(groups),
    )


def _of_window(
    predictor: WindowPredictor,
    target: Target,
    overlap: TrainOverlap,
    dataset: Dataset,
    aligned: Alignment,
) -> Evaluation:
    model = predictor.model
    values = dataset.hardness_rank if target == "hardness_rank" else dataset.shore_a
    cut = labelled_windows(dataset, aligned.contacts, model.spec.duration, values)
    if not len(cut):
        raise InputError(
            f"none of {len(dataset)} pinches has a contact ({aligned.how}), a whole window of "
            f"{1e3 * predictor.duration:.3g} ms and a {target}",
            parameter="data",
        )
    groups = []
    warnings = overlap.warnings(cut.which)
    for title, members in overlap.groups().items():
        part = cut.take(members[cut.which])
        inside: NDArray[np.bool_] = np.ones(len(part), np.bool_)
        if model.spec.classes:
            inside = np.isin(part.y, model.spec.classes)
        if not inside.all():
            warnings.append(
                f"{title}: {counted(int((~inside).sum()), 'pinch')} are of no class that the "
                "model knows and are left out"
            )
        part = part.take(inside)
        if not len(part):
            continue
        predicted = model.predict(part.X)
        scores = score(model.spec.task, part, predicted, seed=0)
        interval_scores = covered(predictor.interval, predicted, part.y, model.spread(part.X))
        at = predictor.duration
        rmse = getattr(scores, "rmse", None)
        groups.append(
            GroupScores(
                title=title,
                predictor=model.kind,
                n=len(part),
                rmse={} if rmse is None else {at: rmse},
                coverage={at: interval_scores["coverage"]} if interval_scores else {},
                width={at: interval_scores["mean_width"]} if interval_scores else {},
                intervals={name: {at: ends} for name, ends in scores.intervals.items()},
                constant=None if model.spec.classes else float(part.y.std()),
                window=scores,
                objects=per_object(part.y, predicted, part.specimens, part.objects),
                level=None if predictor.interval is None else predictor.interval.level,
            )
        )
    if not groups:
        raise InputError("no pinch is of a class that the model knows", parameter="data")
    return Evaluation(
        predictor=model.kind,
        target=target,
        contacts=aligned.how,
        scored=sum(group.n for group in groups),
        left_out=len(dataset) - sum(group.n for group in groups),
        warnings=tuple(warnings),
        groups=tuple(groups),
        duration=predictor.duration,
    )


def _by_seconds(by_ms: Mapping[str, T]) -> dict[float, T]:
    return {int(ms) / 1000: value for ms, value in by_ms.items()}
