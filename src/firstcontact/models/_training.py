"""Labelled windows and contacts, and held-out predictions over splits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import FINGERTIP_WINDOW, Contact, Dataset, Label, Runner
from firstcontact.models._spec import Task
from firstcontact.models._splits import Split
from firstcontact.models._touches import Touches
from firstcontact.models._window_model import WindowModel
from firstcontact.signal import contact_windows

Windows = NDArray[np.float32]
Values = NDArray[np.float64]
#: Default length of a window, s.
DURATION = FINGERTIP_WINDOW


@dataclass(frozen=True, slots=True, eq=False)
class LabelledWindows:
    """Windows with their targets and groups. All arrays share their first axis.

    Parameters
    ----------
    X
        Windows in V, shape (n, samples, 1).
    y
        Target: Shore A, a hardness rank or a class, shape (n,).
    sessions, specimens, objects
        Session, specimen and object of each window, shape (n,).
    test
        Mask of the windows with role ``test``, shape (n,).
    rows
        Position of each window's pinch in the dataset, shape (n,).
    rate
        Sampling rate of the windows, Hz.
    """

    X: Windows
    y: Values
    sessions: NDArray[np.str_]
    specimens: NDArray[np.str_]
    objects: NDArray[np.str_]
    test: NDArray[np.bool_]
    rows: NDArray[np.intp]
    rate: float

    def __len__(self) -> int:
        return len(self.X)

    @property
    def has_sessions(self) -> bool:
        """True if all sessions are known and there are two or more."""
        return _tells_apart(self.sessions)

    @property
    def named_sessions(self) -> NDArray[np.str_] | None:
        """Session of each window; None unless all have a name."""
        return self.sessions if (self.sessions != "").all() else None

    @property
    def clusters(self) -> NDArray[np.str_]:
        """Cluster of each window for the bootstrap: its session, else specimen, else pinch."""
        return resampling_clusters(self.sessions, self.specimens)

    def take(self, rows: NDArray[np.intp] | NDArray[np.bool_]) -> LabelledWindows:
        """Return the windows at these positions, or where a mask is true."""
        return LabelledWindows(
            self.X[rows],
            self.y[rows],
            self.sessions[rows],
            self.specimens[rows],
            self.objects[rows],
            self.test[rows],
            self.rows[rows],
            self.rate,
        )


def resampling_clusters(
    sessions: NDArray[np.str_], specimens: NDArray[np.str_]
) -> NDArray[np.str_]:
    """Return the cluster of each pinch for the bootstrap, which draws whole clusters."""
    for names in (sessions, specimens):
        if _tells_apart(names):
            return names
    return np.arange(len(sessions)).astype(np.str_)


def _tells_apart(names: NDArray[np.str_]) -> bool:
    return len(np.unique(names)) > 1 and bool((names != "").all())


def distinct_specimens(dataset: Dataset) -> NDArray[np.str_]:
    """Return a unique specimen name for each pinch, shape (pinches,).

    People number the specimens of each object, or name all specimens after the material. So a name
    with several objects, levels or ranks means several specimens; object and level are then
    appended to the name.
    """
    labels = [pinch.label for pinch in dataset.pinches]
    kinds: dict[str, set[tuple[str, ...]]] = {}
    for label in labels:
        kinds.setdefault(label.specimen, set()).add(_kind(label))
    names = [
        label.specimen if len(kinds[label.specimen]) == 1 else full_specimen(label)
        for label in labels
    ]
    return np.array(names, dtype=np.str_)


def full_specimen(label: Label) -> str:
    """Return the name of a specimen with its object and level."""
    return f"{label.specimen or 'unnamed'} ({', '.join(_kind(label)) or 'unknown'})"


def _kind(label: Label) -> tuple[str, ...]:
    level = label.hardness_rank if label.shore_a is None else label.shore_a
    return tuple(s for s in (label.object, "" if level is None else f"{level:g}") if s)


def labelled_windows(
    dataset: Dataset,
    contacts: Sequence[Contact | None],
    duration: float,
    target: Values,
    *,
    conditioned: bool = True,
) -> LabelledWindows:
    """Return the windows of the pinches with a contact, a complete window and a target.

    Parameters
    ----------
    dataset
        The pinches.
    contacts
        Contact at which the window of each pinch starts; None if no contact was detected.
    duration
        Length of the windows, s.
    target
        Targets, shape (pinches,), NaN if unknown.
    conditioned
        True to filter the signal; see :func:`firstcontact.signal.contact_windows`.
    """
    cut = contact_windows(dataset, contacts, duration, conditioned=conditioned)
    return label_windows(dataset, *cut, target)


def label_windows(
    dataset: Dataset, X: Windows, has_window: NDArray[np.bool_], target: Values
) -> LabelledWindows:
    """Return the windows of :func:`firstcontact.signal.contact_windows` that have a target."""
    has_target = np.isfinite(target[has_window])
    positions = np.flatnonzero(has_window)[has_target]
    return LabelledWindows(
        X[has_target],
        target[positions],
        dataset.sessions[positions],
        dataset.specimens[positions],
        dataset.objects[positions],
        dataset.test[positions],
        positions,
        dataset.layout.rate,
    )


@dataclass(frozen=True, slots=True, eq=False)
class LabelledTouches:
    """Contacts with objects of known Shore A. All arrays share their first axis.

    Parameters
    ----------
    touches
        Contacts.
    shore_a
        Shore A of the object, shape (n,).
    rows
        Positions of their pinches in the dataset, shape (n,).
    sessions, specimens
        Session and specimen of each contact, "" if unnamed, shape (n,).
    """

    touches: Touches
    shore_a: Values
    rows: NDArray[np.intp]
    sessions: NDArray[np.str_]
    specimens: NDArray[np.str_]

    def __len__(self) -> int:
        return len(self.touches)

    @classmethod
    def cut(cls, dataset: Dataset, contacts: Sequence[Contact | None]) -> LabelledTouches:
        """Return the labelled contacts of a dataset, given each pinch's first contact."""
        touches, rows = Touches.cut(dataset, contacts)
        labelled = np.isfinite(dataset.shore_a[rows])
        rows = rows[labelled]
        return cls(
            touches.take(labelled),
            dataset.shore_a[rows],
            rows,
            dataset.sessions[rows],
            distinct_specimens(dataset)[rows],
        )

    def take(self, rows: NDArray[Any]) -> LabelledTouches:
        """Return the contacts at these positions, or where a mask is true."""
        arrays = [getattr(self, f.name)[rows] for f in fields(self)[1:]]
        return LabelledTouches(self.touches.take(rows), *arrays)

    @property
    def named_sessions(self) -> NDArray[np.str_] | None:
        """Session of each contact; None unless there are several and all have a name."""
        return self.sessions if _tells_apart(self.sessions) else None

    @property
    def clusters(self) -> NDArray[np.str_]:
        """Cluster of each contact: its specimen, or its pinch if the specimen has no name."""
        return np.where(self.specimens == "", self.rows.astype(np.str_), self.specimens)


@dataclass(frozen=True, slots=True, eq=False)
class Fit:
    """Description of one training, and the windows to predict with the trained model.

    Parameters
    ----------
    model
        Name of an estimator, or a regressor with scikit-learn's interface.
    task
        Regression or classification.
    learn
        Training windows.
    ask
        Windows to predict, shape (m, samples, 1).
    seed
        Random seed of the training.
    options
        Further fields of the estimator.
    """

    model: object
    task: Task
    learn: LabelledWindows
    ask: Windows
    seed: int
    options: Mapping[str, Any] = field(default_factory=dict)


def fit_model(fit: Fit) -> WindowModel:
    """Train the model that a :class:`Fit` describes."""
    return fit_models([fit])[0]


def fit_models(fits: Sequence[Fit]) -> Sequence[WindowModel]:
    """Train the models of several :class:`Fit` that differ in their windows only."""
    from firstcontact.models._registry import ESTIMATORS, make_estimator
    from firstcontact.models._window_model import WindowModel

    fit = fits[0]
    estimator = make_estimator(fit.model, fit.task, fit.learn.rate, **fit.options)
    sets = [(f.learn.X, f.learn.y, f.learn.named_sessions) for f in fits]
    with ESTIMATORS.calling(estimator.name):
        models = list(estimator.fit_several(sets, seed=fit.seed))
        if len(models) != len(sets):
            raise TypeError(f"fit_several returned {len(models)} models for {len(sets)} sets")
        for model in models:
            if not isinstance(model, WindowModel):
                raise TypeError(f"{type(model).__name__} was returned by fit, but is no model")
    return models


@dataclass(frozen=True, slots=True, eq=False)
class Question:
    """Estimator, task, data, splits and options of a held-out prediction."""

    model: object
    task: Task
    data: LabelledWindows
    splits: Sequence[Split]
    options: Mapping[str, Any] = field(default_factory=dict)


def held_out(runner: Runner, questions: Sequence[Question], seed: int) -> list[Values]:
    """Return a prediction for each window, by a model that did not learn from its pinch.

    Returns
    -------
    list of ndarray
        Predictions for each question, shape (n,); NaN for windows in no test side.

    Raises
    ------
    ValueError
        A split has undeclared groups on both sides.
    """
    return [answers for answers, _ in held_out_with_spread(runner, questions, seed)]


def held_out_with_spread(
    runner: Runner, questions: Sequence[Question], seed: int
) -> list[tuple[Values, Values | None]]:
    """Return the predictions of :func:`held_out`, each with its predicted standard deviation."""
    from firstcontact.models._registry import find_estimator

    jobs = []
    for number, question in enumerate(questions):
        for split in question.splits:
            split.check(question.data.sessions, question.data.specimens)
        # Weights depend on which sets train together, so jobs do not depend on the number of
        # workers.
        places, size = range(len(question.splits)), find_estimator(question.model).together
        jobs += [(number, places[i : i + size]) for i in range(0, len(places), size)]
    # Read-only views of mappings, as estimators declare them, cannot be pickled.
    plain = [replace(question, options=dict(question.options)) for question in questions]
    answers = runner.map(_held_out, jobs, plain, seed)
    out = [np.full((2, len(q.data)), np.nan) for q in questions]
    has_spread = dict.fromkeys(range(len(questions)), True)
    for (number, places), by_place in zip(jobs, answers, strict=True):
        for place, (predicted, spread) in zip(places, by_place, strict=True):
            test_rows = questions[number].splits[place].test
            out[number][0, test_rows] = predicted
            has_spread[number] &= spread is not None
            out[number][1, test_rows] = np.nan if spread is None else spread
    return [
        (predictions[0], predictions[1] if has_spread[number] else None)
        for number, predictions in enumerate(out)
    ]


def _held_out(
    job: tuple[int, range], questions: Sequence[Question], seed: int
) -> list[tuple[Values, Values | None]]:
    """Return predictions for the test sides of some splits of a question."""
    question = questions[job[0]]
    fits = []
    for split in (question.splits[place] for place in job[1]):
        learn, ask = question.data.take(split.train), question.data.X[split.test]
        fits.append(Fit(question.model, question.task, learn, ask, seed, question.options))
    models = fit_models(fits)
    return [(m.predict(f.ask), m.spread(f.ask)) for m, f in zip(models, fits, strict=True)]
