"""Scores of contact detectors for ``sets``: on real recordings, and on twins with other noise."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from firstcontact.contact import DETECTORS, Detector, make_detector
from firstcontact.contact.closing_start import cut_closings
from firstcontact.contact.contacts import judge_windows
from firstcontact.core import (
    ArgumentError,
    Block,
    Contact,
    Dataset,
    FileError,
    InputError,
    Layout,
    Record,
)
from firstcontact.jobs import Serial
from firstcontact.models import ESTIMATORS, Task
from firstcontact.models.alignment import detect_alignment, found_as_live
from firstcontact.models.labelled_data import DURATION, labelled_windows
from firstcontact.models.training import fit_model
from firstcontact.recording import load_dataset, read_recording
from firstcontact.recording.dataset import find_recordings
from firstcontact.recording.table import read_rows
from firstcontact.signal import resample_dataset
from firstcontact.signal.resampling import MOST_OF_ONE
from firstcontact_lab.report.results import SubjectResults
from firstcontact_lab.report.run import RESULTS
from firstcontact_lab.study.detection import trigger_delays
from firstcontact_lab.study.detection_scores import (
    Delays,
    DetectionScores,
    judge_pinches,
    quantiles,
    score_detector,
)
from firstcontact_lab.study.page import read_study
from firstcontact_lab.study.parts.contacts import CONTACT
from firstcontact_lab.study.parts.hardness import HARDNESS
from firstcontact_lab.study.parts.short_windows import REAL


@dataclass(frozen=True, slots=True, eq=False)
class RealSet:
    name: str
    dataset: Dataset
    noise: tuple[Block, ...]
    front_ends: dict[str, str]
    study: SubjectResults | None
    early: float

    @property
    def layout(self) -> Layout:
        return self.dataset.layout


def find_sets(folder: Path) -> list[RealSet]:
    if not folder.is_dir():
        raise FileError(
            f"{folder} is not a folder: give the folder that has a subfolder for each set"
        )
    places = sorted(p for p in folder.iterdir() if (p / "recordings").is_dir())
    if not places:
        raise FileError(
            f"{folder} contains no set: import recordings into {folder / 'NAME' / 'recordings'}"
        )
    return [_read(place) for place in places]


def _read(place: Path) -> RealSet:
    noise: list[Block] = []
    dataset = load_dataset(place / "recordings")
    if (place / "noise").is_dir():
        for file in find_recordings(place / "noise"):
            recording = read_recording(file)
            if recording.header.layout != dataset.layout:
                raise FileError(
                    f"the layout of {file} differs from that of the set's recordings: import both "
                    "in the same way"
                )
            noise += recording.stretches
    ends = {}
    if (place / "front_ends.csv").exists():
        rows = read_rows(place / "front_ends.csv", ["session", "front_end"])
        ends = {row["session"]: row["front_end"] for _, row in rows}
    study, early = None, 0.0
    if (place / RESULTS).exists():
        results = read_study(place / RESULTS)
        study = results.about
        early = 1e-3 * (study[CONTACT].about.early_ms or 0.0)
    return RealSet(place.name, dataset, tuple(noise), ends, study, early)


#: Largest distance of a placed contact from its label, s.
WITHIN = 0.002


#: Training data of a detector: simulated pinches, the set's other specimens, or none.
TWIN, OTHERS, UNTRAINED = "twin", "others", "nothing"


Firsts = list[Contact | None]


class DetectorScores(Record, frozen=True, kw_only=True):
    """Scores of a detector, by the first contact that it reports in each pinch."""

    n: int
    placed_2_ms: float
    early_triggers: int
    delay_ms: Delays | None = None
    late: int
    missed: int
    noise_false_alarms_per_minute: float | None = None


class SetResults(Record, frozen=True, kw_only=True):
    n: int
    placed_2_ms: float | None = None
    early_triggers: int | None = None
    noise_false_alarms_per_minute: float | None = None
    delay_ms: Delays | None = None
    sensor: str
    rate_hz: float
    front_end: str
    pinches: int
    materials: int
    training: str | None = None
    early_ms: float = 0.0
    noise_seconds: float = 0.0
    detectors: dict[str, dict[str, DetectorScores]] | None = None
    order_rho: float | None = None
    order_p: float | None = None
    class_held_out: dict[str, float] | None = None
    chance: float | None = None


def score_set(recorded_set: RealSet, twin: Dataset) -> tuple[SetResults, list[str]]:
    dataset = recorded_set.dataset
    if dataset.layout.rate > MOST_OF_ONE * twin.layout.rate:
        dataset = resample_dataset(dataset, twin.layout.rate)
    heard = cut_closings(dataset)
    has_contact = np.array([p.first is not None for p in heard.pinches])
    if not has_contact.any():
        return _describe_set(recorded_set), []
    labelled = heard.take(has_contact)
    learned = cut_closings(resample_dataset(twin, dataset.layout.rate))
    detectors: dict[str, dict[str, DetectorScores]] = {}
    firsts: dict[tuple[str, str], Firsts] = {}
    left_out = []
    for name, kind in DETECTORS.items():
        for training in (TWIN, OTHERS) if kind.learns else (UNTRAINED,):
            try:
                found, fitted = _detect_out_of_fold(
                    name, training, labelled, learned, recorded_set.early
                )
            except InputError as error:
                left_out.append(f"{kind.title}, trained on {training}: {error}.")
                continue
            firsts[name, training] = found
            scores = _scored(labelled, found, recorded_set, fitted)
            detectors.setdefault(name, {})[training] = scores
    main = DETECTORS.default
    results = replace(_describe_set(recorded_set), n=len(labelled), detectors=detectors or None)
    trainings = [training for training in (OTHERS, TWIN, UNTRAINED) if (main, training) in firsts]
    if not trainings:
        return results, left_out
    training = trainings[0]
    best = detectors[main][training]
    return replace(
        results,
        training=training,
        placed_2_ms=best.placed_2_ms,
        early_triggers=best.early_triggers,
        delay_ms=best.delay_ms,
        noise_false_alarms_per_minute=best.noise_false_alarms_per_minute,
    ), left_out


def _detect_out_of_fold(
    name: str, training: str, labelled: Dataset, twin: Dataset, early: float
) -> tuple[Firsts, list[Detector]]:
    """Return (first detected contact of each pinch, trained detectors).

    ``training`` selects the pinches to train on. Pinches of the same specimen are never among them.
    Labels may be up to ``early`` s too late.
    """

    def firsts(detector: Detector, pinches: Dataset) -> Firsts:
        return [decision.first for decision in judge_pinches(detector, pinches)]

    if training != OTHERS:
        detector = make_detector(name)
        detector = detector.fit(twin) if training == TWIN else detector
        return firsts(detector, labelled), [detector]
    out: Firsts = [None] * len(labelled)
    specimens = labelled.specimens
    fitted = []
    if len(np.unique(specimens)) < 2:
        raise ArgumentError(
            "the set has only one specimen, so no specimen is left for training: add pinches of "
            "another one"
        )
    for one in np.unique(specimens):
        left_out = specimens == one
        detector = make_detector(name).fit(labelled.take(~left_out), early)
        fitted.append(detector)
        decided = firsts(detector, labelled.take(left_out))
        for place, first in zip(np.flatnonzero(left_out), decided, strict=True):
            out[place] = first
    return out, fitted


def _scored(
    labelled: Dataset, firsts: Firsts, recorded_set: RealSet, detectors: Sequence[Detector]
) -> DetectorScores:
    places, delays = trigger_delays(labelled, firsts)
    alarms = None
    if recorded_set.noise:
        minutes = sum(len(b.data) for b in recorded_set.noise) / recorded_set.layout.rate / 60.0
        alarms = (
            max(_count_alarms(d, recorded_set.noise, recorded_set) for d in detectors) / minutes
        )
    early = recorded_set.early + WITHIN
    with np.errstate(invalid="ignore"):
        good = (places >= -early) & (places <= WITHIN)
    return DetectorScores(
        n=len(places),
        placed_2_ms=float(good.mean()),
        early_triggers=int((places < -early).sum()),
        delay_ms=quantiles(1e3 * delays[good]) if good.any() else None,
        late=int((places > WITHIN).sum()),
        missed=int(np.isnan(places).sum()),
        noise_false_alarms_per_minute=alarms,
    )


def _count_alarms(detector: Detector, noise: Sequence[Block], recorded_set: RealSet) -> int:
    """Return the number of false alarms in noise.

    Consecutive windows that fire count as one alarm.
    """
    alarms = 0
    for number, block in enumerate(noise):
        numbered = Block(block.data, block.first_sample, number)
        decisions = judge_windows(detector, recorded_set.layout, numbered)
        fired = np.array(decisions.fired.any(axis=1))
        fired[1:] &= ~fired[:-1].copy()
        alarms += int(fired.sum())
    return alarms


def _describe_set(recorded_set: RealSet) -> SetResults:
    """Return the results of a set without scores of detectors.

    They are the sensor, the sizes, and the scores of an earlier study.
    """
    order = real = None
    if recorded_set.study:
        order = recorded_set.study[HARDNESS]
        real = next(iter((recorded_set.study[REAL] or {}).values()), None)
    ends = dict.fromkeys(recorded_set.front_ends.values())
    return SetResults(
        n=0,
        sensor=", ".join(dict.fromkeys(str(c.sensor) for c in recorded_set.layout.vibration)),
        rate_hz=recorded_set.layout.rate,
        front_end=", ".join(ends) or "not said",
        pinches=len(recorded_set.dataset),
        materials=len(set(recorded_set.dataset.objects.tolist()) - {""}),
        early_ms=1e3 * recorded_set.early,
        noise_seconds=sum(len(b.data) for b in recorded_set.noise) / recorded_set.layout.rate,
        order_rho=order.spectral_centroid.rho if order else None,
        order_p=order.spectral_centroid.p if order else None,
        class_held_out=real.material_held_out if real else None,
        chance=real.chance if real else None,
    )


#: Header text that names the noise of the pinches (``simulate --noise``).
SAID = "noise of "


class NoiseScores(Record, frozen=True, kw_only=True):
    noise: str
    detectors: dict[str, DetectionScores]
    estimator: str
    estimated: int
    rmse: float | None = None
    rmse_unseen: float | None = None


def noise_scorer(twin: Dataset) -> Callable[[Dataset], NoiseScores]:
    """Train detectors and an estimator on the twin. Return a function that scores a dataset."""
    detectors = {name: make_detector(name).fit(twin) for name in DETECTORS}
    main = detectors[DETECTORS.default]
    contacts = found_as_live(twin, main, 0, Serial())
    windows = labelled_windows(twin, contacts.contacts, DURATION, twin.shore_a)
    learn = windows.take(~windows.test)
    model = fit_model(learn, ESTIMATORS.default, Task.REGRESSION, 0, {})

    def score(dataset: Dataset) -> NoiseScores:
        windows = labelled_windows(
            dataset, detect_alignment(dataset, main).contacts, DURATION, dataset.shore_a
        )
        squares = (model.predict(windows.X) - windows.y) ** 2
        noise = next((note for note in dataset.notes if note.startswith(SAID)), "as modelled")
        return NoiseScores(
            noise=noise.partition(" in place of")[0],
            detectors={kind: score_detector(found, dataset) for kind, found in detectors.items()},
            estimator=ESTIMATORS.default,
            estimated=len(windows),
            rmse=_root_mean(squares[~windows.test]),
            rmse_unseen=_root_mean(squares[windows.test]),
        )

    return score


def _root_mean(squares: NDArray[np.float64]) -> float | None:
    return float(np.sqrt(squares.mean())) if len(squares) else None
