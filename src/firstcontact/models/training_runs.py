"""Training and adaptation of the models of a rig (hand with its sensors) from labelled pinches."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from firstcontact.contact import DETECTORS, Detector, make_detector
from firstcontact.contact.detector_file import is_pretrained
from firstcontact.core import ArgumentError, Dataset, InputError
from firstcontact.core.display import Progress, progress_steps
from firstcontact.core.physics import is_same_rate
from firstcontact.core.quantity import PHYSICAL
from firstcontact.core.records import LONGEST_NAME, to_tree
from firstcontact.core.text import counted
from firstcontact.jobs import Runner, parallel, worker_count
from firstcontact.models.alignment import (
    Alignment,
    Contacts,
    at_known_contacts,
    choose_detector,
    fit_detector,
)
from firstcontact.models.anytime import AnytimeModel
from firstcontact.models.card import Digests, Target, TrainingData, TrainingRecord, pinch_digests
from firstcontact.models.estimator import AnytimeEstimator, Estimator
from firstcontact.models.labelled_data import (
    DURATION,
    LabelledTouches,
    cut_windows,
    distinct_specimens,
    stated_quantity,
)
from firstcontact.models.model import Model, require_dataset, shipped_model
from firstcontact.models.model_file import SavedPredictor, pretrained
from firstcontact.models.registry import find_estimator
from firstcontact.models.rig.combined import CombinedEstimator
from firstcontact.models.rig.network_estimator import NetworkEstimator
from firstcontact.models.training import interval_in_words, scores_in_words, train_final_model
from firstcontact.models.training_plan import Plan, check_seed, has_shore_a, make_plan
from firstcontact.models.values import Task
from firstcontact.models.windows.window_predictor import WindowPredictor
from firstcontact.recording.settings import given_rate
from firstcontact.signal import resample_dataset

#: Estimator of :func:`adapt`, and of :func:`train` besides the window models.
RIG_ESTIMATOR: type[NetworkEstimator] = CombinedEstimator

_log = logging.getLogger("firstcontact.models")


def train(
    data: Dataset,
    estimator: object = None,
    *,
    detector: str | None = None,
    task: Task | str = Task.REGRESSION,
    contacts: Contacts = "detected",
    windows: float | Sequence[float] = (DURATION,),
    level: float = 0.9,
    rate: float | None = None,
    seed: int = 0,
    workers: int = 1,
    progress: Progress = None,
) -> Model:
    """Train a contact detector and stiffness models from labelled pinches.

    Held-out sessions give scores and intervals; the returned model is then fitted to all pinches.
    If the labels are Shore A, or a modulus that gives one, the model also has the package's
    network, adapted to these pinches and averaged with a regression on them. The estimator that
    you name predicts by default.

    Parameters
    ----------
    data
        Labelled pinches. Pinches with role "test" are ignored.
    estimator
        Name of a registered estimator, such as "svm"; ``PACKAGE:NAME`` of a scikit-learn regressor
        or classifier; or a regressor or classifier itself, as a class or an instance. The library
        skops saves it, and accepts only types of scikit-learn, SciPy and NumPy. "combined" makes
        the model of :func:`adapt`, "network" the same without the regression. None trains "svm",
        but the network predicts by default, unless you choose a task or windows.
    detector
        Name of the contact detector to fit. By default the package's detector is used, unless one
        fitted to your pinches detects clearly more contacts in held-out pinches.
    task
        "regression" of the label, or "classification" into the labels of ``data``.
    contacts
        "detected": windows start at contacts that a detector finds, as in live use. It is fitted
        without the session of the pinch, or without the pinch if sessions are unknown. "known":
        windows start at the contacts in ``data``, which come from contact strips or labels.
    windows
        Length of the signal after the contact that a window model uses, s. Several lengths give
        several window models, one for each length.
    level
        Nominal coverage of the prediction intervals of window models, from 0.5 to 0.99.
    rate
        Sampling rate to which the pinches are resampled, Hz. The default is the network's rate for
        labels in Shore A; for a modulus or N/mm, at most that rate; for ranks the pinches' own.
    seed
        Random seed of folds, hyper-parameter search and training.
    workers
        Number of processes; 0 means one per core.
    progress
        True shows a bar. A function is called with the number of steps just finished.

    Returns
    -------
    Model
        Detector and predictors. Its ``notes`` contain the scores on held-out pinches.

    Raises
    ------
    InputError
        A parameter is out of range, or the pinches are too few or have no labels.

    Examples
    --------
    >>> import firstcontact as fc
    >>> data = fc.load("recordings")
    >>> model = fc.train(data, "svm", windows=[0.015])
    >>> model
    Model(detector='logistic', 'svm' at 15 ms, 'combined' from 2 to 15 ms)
    >>> model.predict(data[:3]).estimator
    'svm'
    """
    plan = make_plan(estimator, task, windows, level, rate, seed)
    recorded = training_pinches(data)
    dataset, notes = _resample_pinches(recorded, plan.model_rate(recorded))
    plan.check_sizes(dataset.layout.rate)
    with (
        parallel(worker_count(workers)) as runner,
        progress_steps(progress, 3 + len(plan.durations), "step", "training") as step,
    ):
        is_known = at_known_contacts(contacts, dataset)
        chosen, aligned, reason = choose_detector(dataset, detector, is_known, seed, runner)
        step(2)
        windowed, sentences = _train_windows(plan, dataset, aligned, runner, step)
        networks, remarks = _fit_anytime(plan, dataset, aligned)
        step(1)
    predictors = [*windowed, *networks] if plan.is_explicit else [*networks, *windowed]
    digests = pinch_digests(recorded.pinches)
    notes += [*sentences, *remarks, *filter(None, [reason]), *_closing_notes(predictors, digests)]
    record = _training_data(dataset, aligned, reason, seed)
    _log.info("detector %s, models %s", chosen.name, ", ".join(p.name for p in predictors))
    return Model(
        chosen, tuple(predictors), record, digests, tuple(notes), detector_data(chosen, dataset)
    )


def _train_windows(
    plan: Plan, dataset: Dataset, aligned: Alignment, runner: Runner, step: Callable[[int], object]
) -> tuple[list[SavedPredictor], list[str]]:
    """Train a window model for each window length of the plan.

    ``step`` is called with 1 after each model. Return the predictors, and sentences on their
    scores.
    """
    is_scaled = plan.task is Task.REGRESSION
    cuts = [
        (length, cut_windows(dataset, aligned.contacts, length, is_scaled))
        for length in plan.durations
    ]
    predictors: list[SavedPredictor] = []
    sentences = []
    for length, cut in cuts:
        quantity = stated_quantity(dataset)
        final = train_final_model(
            cut, plan.estimator, plan.task, plan.seed, plan.level, runner, quantity.limits
        )
        record = TrainingRecord(
            pinches=len(cut),
            split=f"scores: {final.split}; the saved model learned from all pinches",
            scores=to_tree(final.scores),
            calibration=final.conformal,
        )
        predictors.append(WindowPredictor(final.model, final.interval, record, quantity))
        sentences += [
            f"{plan.kind.name} ({plan.task}), {1e3 * length:g} ms: {counted(len(cut), 'pinch')}",
            f"held out ({final.split}): {scores_in_words(final.scores, quantity)}",
            interval_in_words(final, quantity),
        ]
        step(1)
    return predictors, sentences


class UnknownRigError(ArgumentError):
    """Error for pinches that the network cannot be adapted to, such as those without Shore A."""


def _fit_anytime(
    plan: Plan, dataset: Dataset, aligned: Alignment
) -> tuple[list[SavedPredictor], list[str]]:
    """Fit the plan's any-time model, such as the network, to pinches with a known Shore A.

    Return a list with this model, and sentences for the user about it. Both lists are empty if no
    pinch has a known Shore A and the plan also has window models. If only the rig is unknown to the
    network, the first list is empty and the sentence states why.
    """
    if plan.learns_windows and not has_shore_a(dataset):
        return [], []
    kind = plan.kind if issubclass(plan.kind, AnytimeEstimator) else RIG_ESTIMATOR
    try:
        model, sentences = _fitted(kind, dataset, aligned, plan.seed)
    except UnknownRigError as error:
        if not plan.learns_windows:
            raise
        _log.info("no network: %s", error.message)
        return [], [f"the network is left out, because {error.message}"]
    prefix = "network: " if plan.learns_windows else ""
    return [model], [prefix + line for line in sentences]


def _fitted(
    kind: type[AnytimeEstimator], dataset: Dataset, aligned: Alignment, seed: int
) -> tuple[AnytimeModel, Sequence[str]]:
    rate = pretrained().rate
    if not is_same_rate(dataset.layout.rate, rate):
        raise UnknownRigError(
            f"the network needs samples at {rate:g} Hz, but these pinches have "
            f"{dataset.layout.rate:g} Hz: train at the network's rate",
            parameter="data",
        )
    if not has_shore_a(dataset):
        raise UnknownRigError(
            "no pinch has a Shore A, which the network needs: record with --shore-a, or with a "
            "plan that has a column shore, or import labels with a column shore_a. For other "
            "labels, train another estimator, such as svm",
            parameter="data",
        )
    labelled = LabelledTouches.cut(dataset, aligned.contacts)
    try:
        return kind(Task.REGRESSION, rate).fit(
            labelled.touches, labelled.shore_a, labelled.named_sessions, seed
        )
    except InputError as error:
        raise UnknownRigError(error.message, parameter="data") from None


def _closing_notes(predictors: Sequence[SavedPredictor], digests: Digests) -> list[str]:
    """Return notes for the user: which estimator is the default, and a warning about copies.

    Copies are pinches with the same samples. Without such notes, the list is empty.
    """
    notes = []
    if len(names := list(dict.fromkeys(p.name for p in predictors))) > 1:
        notes.append(
            f"the estimator {names[0]} predicts by default: name {names[1]} to use it instead"
        )
    if copies := len(digests) - len(np.unique(digests)):
        notes.append(
            f"warning: {counted(copies, 'pinch')} with the samples of another pinch, so held-out "
            "scores may be too good: train without copies"
        )
    return notes


def train_detector(
    data: Dataset, detector: str | None = None, *, rate: float | None = None
) -> Model:
    """Fit a contact detector alone, and return a model that has no predictors.

    ``detector`` names it. Pinches with known contacts are resampled to ``rate``, Hz, if given.
    """
    dataset, notes = _resample_pinches(training_pinches(data), rate)
    fitted = fit_detector(dataset, detector)
    return Model(fitted, notes=tuple(notes), detector_data=detector_data(fitted, dataset))


def adapt(
    data: Dataset | None = None,
    *,
    estimator: str | None = None,
    detector: str | None = None,
    seed: int = 0,
    progress: Progress = None,
) -> Model:
    """Adapt the package's model to your hand by a few pinches of rubber blocks of known Shore A.

    The pre-trained network uses these pinches as examples. Its predictions are averaged with those
    of a regression that is fitted to the same pinches. With fewer than 20 pinches or fewer than 3
    values of Shore A, the network predicts alone.

    Parameters
    ----------
    data
        Labelled pinches. Pinches with role "test" are ignored. None returns the package's model,
        not adapted to any hand.
    estimator
        Name of an estimator that predicts at any time: "combined" (the default), "network" (without
        the regression), or that of a plug-in.
    detector
        Name of the contact detector to fit. By default the package's detector is used, unless a
        detector fitted to your pinches detects clearly more contacts in held-out pinches.
    seed
        Random seed for the cross-validation folds.
    progress
        True shows a bar. A function is called with the number of steps just finished.

    Returns
    -------
    Model
        Detector and network. Its ``notes`` contain the scores on held-out pinches.

    Raises
    ------
    InputError
        The pinches cannot be used to adapt a model, or the model's error on held-out pinches is
        no lower than that of always predicting their mean.

    Examples
    --------
    >>> import firstcontact as fc
    >>> data = fc.load("recordings")
    >>> model = fc.adapt(data)
    >>> model.notes[0]
    'the network was adapted to 59 pinches of 5 Shore A levels'
    """
    check_seed(seed)
    if estimator is not None and issubclass(find_estimator(estimator), Estimator):
        raise ArgumentError(
            f"{estimator} learns from windows: use `firstcontact train --estimator {estimator}`",
            parameter="estimator",
        )
    if data is None:
        if estimator is not None:
            raise ArgumentError(
                f"{estimator} must be adapted to recordings: give at least one", parameter="data"
            )
        shipped = shipped_model()
        if detector is None or detector == shipped.own_detector.name:
            return shipped
        if DETECTORS.find(detector).learns:
            raise ArgumentError(
                f"{detector} must be trained before contacts can be detected: give recordings "
                "for its training",
                parameter="detector",
            )
        return replace(shipped, detector=make_detector(detector))
    chosen = estimator or RIG_ESTIMATOR.name
    return train(data, chosen, detector=detector, seed=seed, progress=progress)


def detector_data(detector: Detector, dataset: Dataset) -> dict[str, Any]:
    """Return a description of the pinches that a detector was fitted to, for its card."""
    if not detector.learns:
        return {}
    if is_pretrained(detector):
        return {"source": "package"}
    return {
        "source": dataset.source,
        "pinches": sum(p.first is not None for p in dataset.pinches),
        "sessions": sorted({str(s) for s in dataset.sessions}),
    }


def training_pinches(data: Dataset) -> Dataset:
    """Return the pinches without role "test". Raise ArgumentError if none is left."""
    require_dataset(data)
    dataset = data.take(~data.test)
    if not len(dataset):
        raise ArgumentError(
            'all pinches have role "test": record some of role "train"', parameter="data"
        )
    return dataset


def _resample_pinches(dataset: Dataset, rate: float | None) -> tuple[Dataset, list[str]]:
    """Return the pinches at the sampling rate ``rate``, Hz, and a note if this changed the rate.

    ``rate`` None keeps the rate.
    """
    given_rate(dataset.layout.rate, "data")
    resampled = dataset if rate is None else resample_dataset(dataset, rate)
    return resampled, list(resampled.notes[len(dataset.notes) :])


def _training_data(dataset: Dataset, aligned: Alignment, detector: str, seed: int) -> TrainingData:
    quantity = stated_quantity(dataset)
    values = dataset.label_values(quantity)
    has_value = np.isfinite(values)
    names = _names(dataset.objects[has_value & (dataset.objects != "")])
    means = {name: float(values[(dataset.objects == name) & has_value].mean()) for name in names}
    return TrainingData(
        source=dataset.source,
        pinches=len(dataset),
        sessions=_names(dataset.sessions),
        specimens=_names(distinct_specimens(dataset)),
        target=cast(Target, quantity.name),
        levels=tuple(np.unique(values[has_value]).tolist()),
        objects=means if quantity in PHYSICAL else {},
        unit=dataset.layout.vibration_unit,
        contacts=aligned.how,
        detector=detector,
        seed=seed,
        notes=dataset.notes,
        recorded_rate_hz=dataset.recorded_rate,
    )


def _names(names: NDArray[np.str_]) -> tuple[str, ...]:
    return tuple(sorted({str(name)[:LONGEST_NAME] for name in names}))
