"""Train and adapt models of a rig from labelled pinches."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from firstcontact.contact import DETECTORS, Detector, make_detector, pretrained_detector
from firstcontact.core import (
    Dataset,
    InputError,
    Progress,
    counted,
    is_same_rate,
    parallel,
    percent,
    progress_steps,
    require_extra,
    to_tree,
    worker_count,
)
from firstcontact.models._adapting import Adapted
from firstcontact.models._alignment import Alignment, fit_detector, found_as_live, known
from firstcontact.models._anytime_file import pretrained
from firstcontact.models._bundle import (
    Model,
    NetworkPredictor,
    WindowPredictor,
    require_dataset,
)
from firstcontact.models._card import LearnedFrom, Provenance
from firstcontact.models._final_model import FinalModel, train_final_model
from firstcontact.models._in_context import InContextModel
from firstcontact.models._labelled_touches import LabelledTouches
from firstcontact.models._learned_from import Digests, pinch_digests
from firstcontact.models._network_estimator import NetworkEstimator
from firstcontact.models._registry import ESTIMATORS, find_estimator
from firstcontact.models._regressor import RegressorEstimator
from firstcontact.models._scores import TaskScores
from firstcontact.models._spec import Task, Values
from firstcontact.models._train_folder import folder_name
from firstcontact.models._training import DURATION, LabelledWindows, labelled_windows
from firstcontact.recording import check_rate
from firstcontact.signal import resample_dataset

Target = Literal["shore_a", "hardness_rank"]
Contacts = Literal["auto", "known", "detected"]
#: Unit of the errors of each target.
UNITS: dict[Target, str] = {"shore_a": "Shore A", "hardness_rank": "ranks"}
#: Longest and shortest window, s.
WINDOWS = (0.001, 1.0)
MOST_SEEDS = 1 << 32


class UnknownRigError(InputError):
    """The pinches do not describe a rig."""


def train(
    data: Dataset,
    estimator: object = ESTIMATORS.default,
    *,
    detector: str | None = None,
    task: Task | str = Task.REGRESSION,
    contacts: Contacts = "auto",
    windows: Sequence[float] = (DURATION,),
    level: float = 0.9,
    rate: float | None = None,
    seed: int = 0,
    workers: int = 1,
    progress: Progress = None,
) -> Model:
    """Train a contact detector and stiffness models from labelled pinches.

    Held-out sessions give scores and intervals; the returned model is then fitted to all pinches.
    Where the labels are Shore A, the network is conditioned on the same pinches.

    Parameters
    ----------
    data
        Pinches; those of role "test" are left out.
    estimator
        Name in the registry of estimators; ``PACKAGE:NAME`` of a regressor or classifier in
        scikit-learn's form; or such an object itself, as a class or an instance (a pipeline). It
        is trained on rows of volts and saved by skops, which takes types of scikit-learn only.
        "network" conditions the network alone, as :func:`adapt` does.
    detector
        Name of the contact detector; the default one by default.
    task
        "regression" of Shore A, or "classification" into the levels of ``data``.
    contacts
        Windows start at "known" contacts or at "detected" ones; "auto" takes known ones where
        there are any. For the network "auto" takes detected ones.
    windows
        Lengths of the windows after the contact, s; one model each. The network has none.
    level
        Coverage of the intervals; that of the network is fixed.
    rate
        Sampling rate to resample the pinches to first, Hz; by default that of the network where
        the labels are Shore A, and else their own.
    seed
        Of folds, hyper-parameter search and training.
    workers
        Processes; 0 takes all cores.
    progress
        True shows a bar; a function is called with the number of steps just finished. The steps
        are the detector, the contacts, each window model and the network.

    Returns
    -------
    Model
        Detector and models; ``notes`` hold the held-out scores.

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
    Model(detector='logistic', 'svm' at 15 ms, 'network' from 2 to 15 ms)
    """
    kind = find_estimator(estimator)
    require_extra(kind)
    _check(windows, level, seed, rate)
    if issubclass(kind, RegressorEstimator):
        kind.check_saved(seed)
    if task not in tuple(Task):
        raise InputError(f"{task!r} is none of {', '.join(Task)}", parameter="task")
    if not kind.takes_windows:
        _check_network(task, windows, level, rate)
        return _train_network(data, detector, contacts, seed, workers, progress)
    dataset = _training_pinches(data)
    digests = pinch_digests(dataset.pinches)
    if rate is None and np.isfinite(dataset.shore_a).any():
        rate = pretrained().rate
    dataset, notes = _resampled(dataset, rate)
    with (
        parallel(worker_count(workers)) as runner,
        progress_steps(progress, 3 + len(windows), "step", "training") as step,
    ):
        fitted = fit_detector(dataset, detector)
        target, values = _target(dataset)
        step(1)
        if known_contacts(contacts, dataset):
            aligned = known(dataset)
        else:
            aligned = found_as_live(dataset, fitted, seed, runner)
        step(1)
        cuts = {}
        for length in sorted(windows):
            cut = labelled_windows(dataset, aligned.contacts, length, values)
            if len(cut) < 2:
                raise InputError(
                    f"{len(cut)} of {len(dataset)} pinches have a contact, a whole window of "
                    f"{1e3 * length:g} ms and a {target}: record or import longer pinches",
                    parameter="data",
                )
            cuts[length] = cut
        models = []
        for length, cut in cuts.items():
            final = train_final_model(
                cut, estimator, Task(task), seed, level, runner, target == "shore_a"
            )
            provenance = Provenance(
                data=_learned_from(cut, dataset, aligned, target, seed),
                split=f"scores: {final.split}; the saved model learned from all pinches",
                scores=to_tree(final.scores),
                interval=final.interval,
                conformal=final.conformal,
            )
            name = "" if len(cuts) == 1 else folder_name(round(1e3 * length, 6))
            models.append(WindowPredictor(final.model, provenance, digests[cut.which], name))
            notes += [
                f"{kind.name} ({Task(task)}), {1e3 * length:g} ms: {counted(len(cut), 'pinch')}",
                f"held out ({final.split}): {scores_in_words(final.scores, target)}",
                _interval_in_words(final, target),
            ]
            step(1)
        network = None
        if target == "shore_a":
            try:
                network, sentences = _conditioned(dataset, digests, seed, aligned)
                notes += [f"network: {line}" for line in sentences]
            except UnknownRigError as error:
                notes.append(f"no network: {error.message}")
        step(1)
    return Model(fitted, tuple(models), network, tuple(notes), detector_data(fitted, dataset))


def train_detector(
    data: Dataset, detector: str | None = None, *, rate: float | None = None
) -> Model:
    """Train a contact detector alone, from pinches with known contacts.

    Parameters
    ----------
    data
        Pinches; those of role "test" are left out. They need no label.
    detector
        Name of the detector; the default one by default.
    rate
        Sampling rate to resample the pinches to first, Hz; by default their own.

    Raises
    ------
    InputError
        The detector cannot learn from these pinches.
    """
    dataset, notes = _resampled(_training_pinches(data), rate)
    fitted = fit_detector(dataset, detector)
    return Model(fitted, (), None, tuple(notes), detector_data(fitted, dataset))


def adapt(
    data: Dataset | None = None,
    *,
    detector: str | None = None,
    seed: int = 0,
    progress: Progress = None,
) -> Model:
    """Condition the pre-trained network on a rig, from a few pinches of blocks of known Shore A.

    Parameters
    ----------
    data
        Pinches; those of role "test" are left out. None gives a model that knows no rig.
    detector
        Name of the contact detector; the default one, or without data that of the package.
    seed
        Of the folds that hold pinches out.
    progress
        As of :func:`train`; the steps are the detector, the contacts and the network.

    Returns
    -------
    Model
        Detector and network; ``notes`` hold the held-out scores.

    Raises
    ------
    InputError
        The pinches do not describe a rig, or the network predicts them no better than their mean.

    Examples
    --------
    >>> import firstcontact as fc
    >>> data = fc.load("recordings")
    >>> model = fc.adapt(data)
    >>> model.notes[0]
    'the rig is known by 60 pinches of 5 Shore A levels'
    """
    _check((DURATION,), 0.9, seed, None)
    if data is None:
        fallback = pretrained_detector()
        if detector is not None and detector != fallback.name:
            if DETECTORS.find(detector).learns:
                raise InputError(
                    f"{detector} has to be fitted: name recordings, too", parameter="detector"
                )
            fallback = make_detector(detector)
        return Model(fallback, (), NetworkPredictor(pretrained()))
    return _train_network(data, detector, "auto", seed, 1, progress)


def known_contacts(contacts: str, dataset: Dataset) -> bool:
    """Return True if windows start at the known contacts of these pinches.

    Raises
    ------
    InputError
        Known contacts are demanded and there are none.
    """
    if contacts not in get_args(Contacts):
        raise InputError(
            f"{contacts!r} is none of {', '.join(get_args(Contacts))}", parameter="contacts"
        )
    has_known = any(p.first is not None for p in dataset.pinches)
    if contacts == "known" and not has_known:
        raise InputError(
            'no pinch has a known first contact: use "detected", or import with first_contact',
            parameter="contacts",
        )
    return contacts == "known" or (contacts == "auto" and has_known)


def scores_in_words(scores: TaskScores, target: Target) -> str:
    """Format scores on one line, errors in the unit of the target."""
    unit = UNITS[target]
    units = {"rmse": unit, "mae": unit, "mse": f"{unit}²", "bias": unit}
    numbers = [
        f"{name} {value:.2f} {unit}"
        for name, unit in units.items()
        if (value := getattr(scores, name, None)) is not None
    ]
    if (accuracy := getattr(scores, "accuracy", None)) is not None:
        numbers.insert(0, f"accuracy {percent(accuracy)}")
    return f"{', '.join(numbers)}, {counted(scores.n, 'pinch')}"


def detector_data(detector: Detector, dataset: Dataset) -> dict[str, Any]:
    """Describe the data that a detector was fitted to, for its card."""
    if not detector.learns:
        return {}
    return {
        "source": dataset.source,
        "pinches": sum(p.first is not None for p in dataset.pinches),
        "sessions": sorted({str(s) for s in dataset.sessions}),
    }


def _check(windows: Sequence[float], level: float, seed: int, rate: float | None) -> None:
    least, most = WINDOWS
    if not windows or not all(least <= length <= most for length in windows):
        raise InputError("lengths must lie between 1 ms and 1 s", parameter="windows")
    if len(set(windows)) < len(windows):
        raise InputError("two lengths are the same: give each once", parameter="windows")
    if not 0 <= seed < MOST_SEEDS:
        raise InputError(f"it must lie between 0 and {MOST_SEEDS - 1}", parameter="seed")
    if not 0.5 <= level <= 0.99:
        raise InputError("it must lie between 0.5 and 0.99", parameter="level")
    if rate is not None:
        check_rate("rate", rate)


def _training_pinches(data: Dataset) -> Dataset:
    require_dataset(data)
    dataset = data.take(~data.test)
    if not len(dataset):
        raise InputError(
            'all pinches have role "test": record some of role "train"', parameter="data"
        )
    return dataset


def _resampled(dataset: Dataset, rate: float | None) -> tuple[Dataset, list[str]]:
    """Resample pinches where their rate differs; the note says what was done."""
    check_rate("data: the rate", dataset.layout.rate)
    if rate is None or is_same_rate(rate, dataset.layout.rate):
        return dataset, []
    resampled = resample_dataset(dataset, rate)
    return resampled, [resampled.notes[-1]]


def _target(dataset: Dataset) -> tuple[Target, Values]:
    targets: dict[Target, Values] = {
        "shore_a": dataset.shore_a,
        "hardness_rank": dataset.hardness_rank,
    }
    for name, values in targets.items():
        if np.isfinite(values).any():
            return name, values
    raise InputError(
        "no pinch has a shore_a or a hardness_rank: record or import labels", parameter="data"
    )


def _learned_from(
    cut: LabelledWindows, dataset: Dataset, aligned: Alignment, target: Target, seed: int
) -> LearnedFrom:
    names = sorted({str(name) for name in cut.objects} - {""})
    shore = {name: float(cut.y[cut.objects == name].mean()) for name in names}
    return LearnedFrom(
        source=dataset.source,
        pinches=len(cut),
        sessions=_names(cut.sessions),
        specimens=_names(cut.specimens),
        target=target,
        levels=tuple(sorted({float(v) for v in cut.y})),
        objects=shore if target == "shore_a" else {},
        contacts=aligned.how,
        seed=seed,
        notes=dataset.notes,
        recorded_rate_hz=dataset.recorded_rate,
    )


def _names(names: NDArray[np.str_]) -> tuple[str, ...]:
    return tuple(sorted({str(name) for name in names}))


def _interval_in_words(final: FinalModel, target: Target) -> str:
    if final.interval is None:
        return f"no interval: {final.conformal['none']}"
    checked = final.conformal["held_out"]
    if not checked:
        return f"interval at level {final.interval.level:g}: too few pinches to check it on"
    return (
        f"held out, interval from other folds: interval at level {final.interval.level:g} held "
        f"{percent(checked['coverage'])} of {checked['n']} pinches, mean width "
        f"{checked['mean_width']:.1f} {UNITS[target]}"
    )


def _check_network(task: str, windows: Sequence[float], level: float, rate: float | None) -> None:
    """Refuse what the network cannot do; InputError names the parameter."""
    base = pretrained()
    if task != Task.REGRESSION:
        raise InputError(f"network does not learn {task}: choose regression", parameter="task")
    if tuple(windows) != (DURATION,):
        raise InputError(
            "the network predicts from 2 to 15 ms after a contact: leave the lengths out",
            parameter="windows",
        )
    if level != base.level:
        raise InputError(f"intervals of the network have {base.level:g}", parameter="level")
    if rate is not None and not is_same_rate(rate, base.rate):
        raise InputError(f"the network takes {base.rate:g} Hz: leave it out", parameter="rate")


def _train_network(
    data: Dataset,
    detector: str | None,
    contacts: Contacts,
    seed: int,
    workers: int,
    progress: Progress,
) -> Model:
    """Return a detector and the network conditioned on the rig of these pinches."""
    dataset = _training_pinches(data)
    digests = pinch_digests(dataset.pinches)
    # The detector gets the network's rate, too: both listen to one stream.
    dataset, notes = _resampled(dataset, pretrained().rate)
    with progress_steps(progress, 3, "step", "adapting") as step:
        fitted = fit_detector(dataset, detector)
        step(1)
        if contacts != "auto" and known_contacts(contacts, dataset):
            aligned = known(dataset)
        else:
            with parallel(worker_count(workers)) as runner:
                aligned = found_as_live(dataset, fitted, seed, runner)
        step(1)
        network, sentences = _conditioned(dataset, digests, seed, aligned)
        step(1)
    return Model(fitted, (), network, (*notes, *sentences))


def _conditioned(
    dataset: Dataset, digests: Digests, seed: int, contacts: Alignment
) -> tuple[NetworkPredictor, list[str]]:
    """Condition the network on the rig of these pinches; give it with what there is to say.

    ``digests`` are of the pinches as they were recorded.

    Raises
    ------
    UnknownRigError
        The pinches do not describe a rig.
    """
    base = pretrained()
    if not is_same_rate(dataset.layout.rate, base.rate):
        raise UnknownRigError(
            f"it takes {base.rate:g} Hz and these pinches have {dataset.layout.rate:g} Hz",
            parameter="data",
        )
    if not np.isfinite(dataset.shore_a).any():
        raise UnknownRigError(
            "no pinch has a Shore A, and a rig is known by objects of known Shore A: record with "
            "--shore-a or a plan with a column shore, or import with a column shore_a",
            parameter="data",
        )
    labelled = LabelledTouches.of(dataset, contacts.contacts)
    try:
        made = NetworkEstimator(Task.REGRESSION, base.rate).fit_contacts(labelled, seed)
    except InputError as error:
        raise UnknownRigError(error.message, parameter="data") from None
    if made.refusal:
        raise UnknownRigError(made.refusal, parameter="data")
    levels = [float(level) for level in np.unique(labelled.shore_a)]
    about = {
        "pinches": len(labelled),
        "levels": levels,
        "contacts": contacts.how,
        "source": dataset.source,
        "sessions": list(_names(labelled.sessions)),
        "specimens": list(_names(labelled.specimens)),
        "scores": _held_out_scores(made),
    }
    predictor = NetworkPredictor(made.model, about, digests[labelled.which])
    return predictor, [
        f"the rig is known by {counted(len(labelled), 'pinch')} of "
        f"{counted(len(levels), 'Shore A level')}",
        *_checked_in_words(base, made),
    ]


def _held_out_scores(made: Adapted) -> dict[str, float]:
    scores = {f"held out, {scheme}": round(score, 3) for scheme, score in made.scores.items()}
    if made.check is not None:
        scores |= {
            "held out, always the mean": round(made.mean_rmse, 3),
            "held out, least coverage": round(made.check.coverage, 3),
            "intervals widened": round(float(made.check.scales.max()), 3),
        }
    return scores


def _checked_in_words(base: InContextModel, made: Adapted) -> list[str]:
    if made.check is None:
        return ["errors and intervals are not checked: too few pinches to hold some out"]
    compared = ", ".join(f"{scheme}: rmse {score:.2f}" for scheme, score in made.scores.items())
    widest = made.check.scales.max()
    widened = f"now up to {widest:.2f} times as wide" if widest > 1 else "kept"
    return [
        f"fingers as one or each by itself, on pinches held out: {compared} Shore A (always "
        f"answering the mean: {made.mean_rmse:.2f}); kept: {made.way}",
        f"{100 * base.level:.0f} % intervals held at least {percent(made.check.coverage)} of "
        f"{counted(made.check.n, 'pinch')} held out, at each time: {widened}",
    ]
