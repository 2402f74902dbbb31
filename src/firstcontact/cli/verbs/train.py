"""``firstcontact train``: models, their cards and a contact detector out of recordings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

from firstcontact.cli.choices import one_of
from firstcontact.cli.cluster import where
from firstcontact.contact import DETECTORS
from firstcontact.core import InputError, counted, need_for, percent, same_rate
from firstcontact.models import ESTIMATORS, check_replaceable, folder_name, replaced

if TYPE_CHECKING:
    from firstcontact.contact import Detector
    from firstcontact.core import Dataset, Runner
    from firstcontact.models import (
        Alignment,
        Digests,
        FinalModel,
        LabelledWindows,
        LearnedFrom,
        TaskScores,
    )

Target = Literal["shore_a", "hardness_rank"]
#: Unit of errors of a target.
UNITS = {"shore_a": "Shore A", "hardness_rank": "ranks"}


@dataclass(frozen=True)
class Train:
    """Learn stiffness models from the pinches of role "train"; save them with a detector.

    Where the pinches have a Shore A, an any-time model of their rig is saved beside them.
    """

    data: tyro.conf.Positional[Path]
    """A recording, or a folder of recordings."""
    out: Path
    """Folder for the model and the detector; a training that is in it is replaced whole."""
    model: Annotated[str, one_of(ESTIMATORS)] = ESTIMATORS.default
    """What learns."""
    detector: Annotated[str | None, one_of(DETECTORS)] = None
    """What finds contacts; left out: the usual one where it can learn from these pinches, else one
    that learns nothing."""
    detector_only: bool = False
    """Make the detector and no model: pinches need known contacts and no hardness."""
    task: Literal["regression", "classification"] = "regression"
    """Any Shore A, or one of those learned from."""
    contacts: Literal["auto", "truth", "detected"] = "auto"
    """Where windows start: known contacts, or found ones as live; auto: known if there are any."""
    window_ms: tuple[float, ...] = (15.0,)
    """Length of the window after the contact, ms; several make a model each, in folders as 03ms."""
    level: float = 0.9
    """Share of intervals that are to hold the truth."""
    seed: int = 0
    """Of the folds, the search and the training."""
    rate: float | None = None
    """Hz to resample the pinches to first, for use at that rate; left out: as they were recorded"""
    workers: int = 1
    """Processes; 0 takes all cores."""
    cluster: str | None = None
    """A Dask cluster that does the work instead of this machine: tcp://HOST:PORT."""

    def run(self) -> None:
        """Score on held-out sessions, with an interval; then learn from everything and save."""
        estimator = ESTIMATORS.find(self.model)
        need_for(estimator)
        self._check()
        names = {ms: folder_name(ms) for ms in sorted(self.window_ms)}
        if self.detector_only:
            names = {}
        elif len(names) == 1:
            names = dict.fromkeys(names, "")
        former = check_replaceable(self.out, names.values(), anytime=not self.detector_only)
        from firstcontact.core import asked_workers, parallel, replacing_folder

        with (
            where(self.cluster),
            replacing_folder(self.out) as making,
            parallel(asked_workers(self.workers)) as runner,
        ):
            lines = self._learn({ms: making / name for ms, name in names.items()}, making, runner)
        for line in lines:
            print(line)
        if former:
            print(replaced(self.out))

    def _learn(self, folders: Mapping[float, Path], making: Path, runner: Runner) -> list[str]:
        """Learn everything into a folder that is made; what to say when it is in its place."""
        from firstcontact.cli.losses import warn_of
        from firstcontact.contact import save_detector, vouched
        from firstcontact.models import (
            Task,
            fit_detector,
            found_as_live,
            known,
            labelled_windows,
            pinch_digests,
            train_final_model,
        )
        from firstcontact.recording import load_dataset

        dataset = load_dataset(self.data)
        warn_of(dataset)
        dataset = dataset.take(~dataset.test)
        if not len(dataset):
            raise InputError(
                f'{self.data}: all pinches have role "test": none is there to learn from'
            )
        digests = pinch_digests(dataset.pinches)
        dataset = at_rate(dataset, self.rate, self.data)
        detector = fit_detector(dataset, self.detector)
        if self.detector_only:
            save_detector(detector, making, _learned(detector, dataset))
            return [f"detector {detector.name}: {self.out}"]
        target, values = _target(dataset, self.data)
        truth = aligned_by_truth(self.contacts, dataset, self.data)
        contacts = known(dataset) if truth else found_as_live(dataset, detector, self.seed, runner)
        everything = {}
        for ms in folders:
            cut = labelled_windows(dataset, contacts.contacts, 1e-3 * ms, values)
            if len(cut) < 2:
                raise InputError(
                    f"{self.data}: {len(cut)} of {len(dataset)} pinches have a contact, a "
                    f"whole window of {ms:g} ms and a {target}: import longer pinches"
                )
            everything[ms] = cut
        save_detector(detector, making, _learned(detector, dataset))
        lines = []
        for ms, folder in folders.items():
            data = everything[ms]
            kept = train_final_model(
                data,
                self.model,
                Task(self.task),
                self.seed,
                self.level,
                runner,
                target == "shore_a",
            )
            learned_from = self._learned_from(data, dataset, contacts, target)
            _save(kept, folder, learned_from, digests[data.which], vouched(making))
            lines += [
                f"{self.model} ({self.task}) learned from {counted(len(data), 'pinch')}: "
                f"{self.out / folder.relative_to(making)}",
                f"held out ({kept.split}): {in_words(kept.scores, target)}",
                _interval_in_words(kept, target),
            ]
        if target == "shore_a":
            lines += _anytime(dataset, digests, detector, contacts, self.data, making, self.seed)
        return [*lines, f"detector {detector.name}: {self.out}"]

    def _check(self) -> None:
        from firstcontact.recording import check_rate

        if (
            not self.window_ms
            or not all(1.0 <= ms <= 1000.0 for ms in self.window_ms)
            or len(set(self.window_ms)) < len(self.window_ms)
            or not 0 <= self.seed < 1 << 32
        ):
            raise InputError(
                "--window-ms must lie between 1 and 1000, each length once, and --seed between 0 "
                "and 4294967295"
            )
        from firstcontact.core import asked_workers

        asked_workers(self.workers)
        if not 0.5 <= self.level <= 0.99:
            raise InputError("--level must lie between 0.5 and 0.99")
        if self.rate is not None:
            check_rate("--rate", self.rate)

    def _learned_from(
        self, data: LabelledWindows, dataset: Dataset, contacts: Alignment, target: Target
    ) -> LearnedFrom:
        from firstcontact.models import LearnedFrom

        return LearnedFrom(
            source=dataset.source,
            pinches=len(data),
            sessions=tuple(sorted({str(s) for s in data.sessions})),
            specimens=tuple(sorted({str(s) for s in data.specimens})),
            target=target,
            levels=tuple(sorted({float(v) for v in data.y})),
            objects=_objects(data) if target == "shore_a" else {},
            contacts=contacts.how,
            seed=self.seed,
            notes=dataset.notes,
            recorded_rate_hz=dataset.recorded_rate,
        )


def _save(
    kept: FinalModel, folder: Path, learned_from: LearnedFrom, digests: Digests, detector: str
) -> None:
    from firstcontact.core import to_tree
    from firstcontact.models import Provenance, save_model

    card = Provenance(
        data=learned_from,
        split=f"scores: {kept.split}; the saved model learned from all pinches",
        scores=to_tree(kept.scores),
        interval=kept.interval,
        conformal=kept.conformal,
        detector=detector,
    )
    save_model(kept.model, folder, card, digests)


def _anytime(
    dataset: Dataset,
    digests: Digests,
    detector: Detector,
    contacts: Alignment,
    data: Path,
    making: Path,
    seed: int,
) -> list[str]:
    """Write the any-time model of these pinches' rig beside the others; what there is to say."""
    from firstcontact.cli.verbs.adapt import UnknownRigError, adapted
    from firstcontact.models import pretrained

    base = pretrained()
    rate = dataset.layout.rate
    if not same_rate(rate, base.rate):
        return [f"no any-time model: it takes {base.rate:g} Hz and these pinches have {rate:g} Hz"]
    try:
        said = adapted(base, dataset, digests, detector, data, making, seed, contacts)
    except UnknownRigError as error:
        return [f"no any-time model: {error}"]
    return [f"any-time model: {line}" for line in said]


def _objects(data: LabelledWindows) -> dict[str, float]:
    """Mean Shore A of each named object."""
    names = sorted({str(name) for name in data.objects} - {""})
    return {name: float(data.y[data.objects == name].mean()) for name in names}


def _learned(detector: Detector, dataset: Dataset) -> dict[str, Any]:
    if not detector.learns:
        return {}
    return {
        "source": dataset.source,
        "pinches": sum(p.first is not None for p in dataset.pinches),
        "sessions": sorted({str(s) for s in dataset.sessions}),
    }


def _target(dataset: Dataset, path: Path) -> tuple[Target, Any]:
    import numpy as np

    targets: dict[Target, Any] = {
        "shore_a": dataset.shore_a,
        "hardness_rank": dataset.hardness_rank,
    }
    for name, values in targets.items():
        if np.isfinite(values).any():
            return name, values
    raise InputError(f"{path}: no pinch has a shore_a or a hardness_rank: import it with labels")


def at_rate(dataset: Dataset, rate: float | None, path: Path) -> Dataset:
    """The pinches at that rate, or as they are where it is None; says what was done."""
    from firstcontact.recording import check_rate
    from firstcontact.signal import resample_dataset

    check_rate(f"{path}: the rate", dataset.layout.rate)
    if rate is None or rate == dataset.layout.rate:
        return dataset
    resampled = resample_dataset(dataset, rate)
    print(resampled.notes[-1])
    return resampled


def aligned_by_truth(asked: str, dataset: Dataset, path: Path) -> bool:
    """Whether ``--contacts`` means the known contacts of these pinches.

    Raises
    ------
    InputError
        Known contacts were asked for and there are none.
    """
    known = any(p.first is not None for p in dataset.pinches)
    if asked == "truth" and not known:
        raise InputError(
            f"{path}: no pinch has a known first contact: use --contacts detected, "
            "or import it with first_contact"
        )
    return asked == "truth" or (asked == "auto" and known)


def in_words(scores: TaskScores, target: str) -> str:
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


def coverage_in_words(found: Mapping[str, float], level: float) -> str:
    """How often an interval held the truth, on one line."""
    return (
        f"interval at level {level:g} held {percent(found['coverage'])} of {found['n']} "
        f"pinches, mean width {found['mean_width']:.1f}"
    )


def _interval_in_words(kept: FinalModel, target: str) -> str:
    if kept.interval is None:
        return f"no interval: {kept.conformal['none']}"
    checked = kept.conformal["held_out"]
    if not checked:
        return f"interval at level {kept.interval.level:g}: too few pinches to check it on"
    words = coverage_in_words(checked, kept.interval.level)
    return f"held out, interval from other folds: {words} {UNITS[target]}"
