"""Scores of detectors on sets of real recordings.

The detectors were trained on the twin, or on other specimens of the set.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from msgspec.structs import asdict, replace
from numpy.typing import NDArray

from firstcontact.contact import (
    DETECTORS,
    Detector,
    cut_closings,
    find_onsets,
    judge_windows,
    make_detector,
)
from firstcontact.core import Block, Contact, Dataset, InputError, Record
from firstcontact.models import Delays, judge_pinches, quantiles
from firstcontact.signal import resample_dataset
from firstcontact_lab.study.detection import trigger_delays
from firstcontact_lab.study.parts.hardness import HARDNESS
from firstcontact_lab.study.parts.short_windows import REAL
from firstcontact_lab.study.set_folder import RealSet

#: Largest distance of a placed contact from its label, s.
WITHIN = 0.002
#: Training data of a detector: simulated pinches, the set's other specimens, or none.
TWIN, OTHERS, NOTHING = "twin", "others", "nothing"

Firsts = list[Contact | None]


class Placement(Record, frozen=True, kw_only=True):
    """Placement of a detector's first triggers, on recordings that were not resampled."""

    n: int
    placed_2_ms: float
    early_triggers: int
    delay_ms: Delays | None = None


class DetectorScores(Placement, frozen=True, kw_only=True):
    """Scores of a detector on a set."""

    late: int
    missed: int
    noise_false_alarms_per_minute: float | None = None


class FinderScores(Record, frozen=True, kw_only=True):
    """Scores of the onset finder, which also uses samples after a contact."""

    placed_2_ms: float
    from_label_ms: Delays | None = None
    from_detector_ms: Delays | None = None


class Recorded(Placement, frozen=True, kw_only=True):
    """Scores of the default detector on one recording of a set."""

    front_end: str


class SetResults(Record, frozen=True, kw_only=True):
    """Results of one set of real recordings."""

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
    files: dict[str, Recorded] | None = None
    finder: FinderScores | None = None
    order_rho: float | None = None
    order_p: float | None = None
    class_held_out: dict[str, float] | None = None
    chance: float | None = None


def score_set(
    recorded_set: RealSet, twin: Dataset, say: Callable[[str], object] = lambda line: None
) -> SetResults:
    """Return the scores of every detector on one set."""
    heard = cut_closings(recorded_set.dataset)
    has_contact = np.array([p.first is not None for p in heard.pinches])
    labelled = heard.take(has_contact) if has_contact.any() else None
    detectors: dict[str, dict[str, DetectorScores]] = {}
    firsts: dict[tuple[str, str], Firsts] = {}
    if labelled is not None:
        learned = cut_closings(resample_dataset(twin, recorded_set.layout.rate))
        for name, kind in DETECTORS.items():
            ways = (TWIN, OTHERS) if kind.learns else (NOTHING,)
            for training in ways:
                say(f"{recorded_set.name}: {kind.title}, trained on {training}")
                try:
                    set_results, fitted = _judged(
                        name, training, labelled, learned, recorded_set.early
                    )
                except InputError as error:
                    say(f"{recorded_set.name}: {kind.title} left out: {error}")
                    continue
                firsts[name, training] = set_results
                scored = _scored(labelled, set_results, recorded_set, fitted)
                detectors.setdefault(name, {})[training] = scored
    main = DETECTORS.default
    able = [training for training in (OTHERS, TWIN, NOTHING) if (main, training) in firsts]
    results = _about(recorded_set, detectors, labelled)
    if not able or labelled is None:
        return results
    training = able[0]
    best = detectors[main][training]
    return replace(
        results,
        training=training,
        placed_2_ms=best.placed_2_ms,
        early_triggers=best.early_triggers,
        delay_ms=best.delay_ms,
        noise_false_alarms_per_minute=best.noise_false_alarms_per_minute,
        files=_by_file(recorded_set, labelled, firsts[main, training]),
        finder=_finder(recorded_set, labelled, firsts[main, training]),
    )


def _judged(
    name: str, training: str, labelled: Dataset, twin: Dataset, early: float
) -> tuple[Firsts, list[Detector]]:
    """Return each pinch's first trigger, from a detector not trained on the pinch's specimen."""

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
        raise InputError(
            "the set has only one specimen, so no specimen is left for training: add pinches of "
            "another one"
        )
    for one in np.unique(specimens):
        left_out = specimens == one
        detector = make_detector(name).fit(labelled.take(~left_out), early)
        fitted.append(detector)
        for place, first in zip(
            np.flatnonzero(left_out), firsts(detector, labelled.take(left_out)), strict=True
        ):
            out[place] = first
    return out, fitted


def _scored(
    labelled: Dataset, firsts: Firsts, recorded_set: RealSet, detectors: Sequence[Detector]
) -> DetectorScores:
    places, delays = trigger_delays(labelled, firsts)
    alarms = None
    if recorded_set.noise:
        minutes = sum(len(b.data) for b in recorded_set.noise) / recorded_set.layout.rate / 60.0
        alarms = max(_alarms(d, recorded_set.noise, recorded_set) for d in detectors) / minutes
    return DetectorScores(
        **asdict(_placement(places, delays, recorded_set.early)),
        late=int((places > WITHIN).sum()),
        missed=int(np.isnan(places).sum()),
        noise_false_alarms_per_minute=alarms,
    )


def _placement(places: NDArray[np.float64], delays: NDArray[np.float64], early: float) -> Placement:
    good = _good(places, early)
    return Placement(
        n=len(places),
        placed_2_ms=float(good.mean()),
        early_triggers=int((places < -(early + WITHIN)).sum()),
        delay_ms=quantiles(1e3 * delays[good]) if good.any() else None,
    )


def _good(places: NDArray[np.float64], early: float) -> NDArray[np.bool_]:
    with np.errstate(invalid="ignore"):
        return np.asarray((places >= -(early + WITHIN)) & (places <= WITHIN))


def _alarms(detector: Detector, noise: Sequence[Block], recorded_set: RealSet) -> int:
    """Return the number of false alarms in noise. Successive windows that fire are one alarm."""
    alarms = 0
    for number, block in enumerate(noise):
        numbered = Block(block.data, block.first_sample, number)
        decisions = judge_windows(detector, recorded_set.layout, numbered)
        fired = np.array(decisions.fired.any(axis=1))
        fired[1:] &= ~fired[:-1].copy()
        alarms += int(fired.sum())
    return alarms


def _by_file(recorded_set: RealSet, labelled: Dataset, firsts: Firsts) -> dict[str, Recorded]:
    places, delays = trigger_delays(labelled, firsts)
    out = {}
    for session in dict.fromkeys(labelled.sessions.tolist()):
        rows = labelled.sessions == session
        placement = _placement(places[rows], delays[rows], recorded_set.early)
        out[session] = Recorded(**asdict(placement), front_end=recorded_set.front_end(session))
    return out


def _finder(recorded_set: RealSet, labelled: Dataset, firsts: Firsts) -> FinderScores:
    """Return the scores of the onset finder."""
    from_label, from_detector = [], []
    rate = recorded_set.layout.rate
    for pinch, first in zip(labelled.pinches, firsts, strict=True):
        onsets = [o.sample + pinch.first_sample for o in find_onsets(pinch.vibration(), rate)]
        if not onsets or pinch.first is None:
            from_label.append(np.nan)
            continue
        at = pinch.first.sample
        nearest = min(onsets, key=lambda o, at=at: abs(o - at))  # type: ignore[misc]
        from_label.append((nearest - at) / rate)
        if first is not None:
            from_detector.append(1e3 * abs(nearest - first.sample) / rate)
    distances = np.array(from_label)
    absolute = np.abs(distances[np.isfinite(distances)])
    return FinderScores(
        placed_2_ms=float(_good(distances, recorded_set.early).mean()),
        from_label_ms=quantiles(1e3 * absolute) if len(absolute) else None,
        from_detector_ms=quantiles(np.array(from_detector)) if from_detector else None,
    )


def _about(
    recorded_set: RealSet, detectors: dict[str, dict[str, DetectorScores]], labelled: Dataset | None
) -> SetResults:
    """Return the results of a set, including results of an earlier study of the set."""
    order = recorded_set.study[HARDNESS] if recorded_set.study else None
    real = (
        next(iter((recorded_set.study[REAL] or {}).values()), None) if recorded_set.study else None
    )
    ends = list(dict.fromkeys(recorded_set.front_ends.values()))
    return SetResults(
        n=0 if labelled is None else len(labelled),
        sensor=", ".join(dict.fromkeys(str(c.sensor) for c in recorded_set.layout.vibration)),
        rate_hz=recorded_set.layout.rate,
        front_end=", ".join(ends) or "not said",
        pinches=len(recorded_set.dataset),
        materials=len(set(recorded_set.dataset.objects.tolist()) - {""}),
        early_ms=1e3 * recorded_set.early,
        noise_seconds=sum(len(b.data) for b in recorded_set.noise) / recorded_set.layout.rate,
        detectors=detectors or None,
        order_rho=order.spectral_centroid.rho if order else None,
        order_p=order.spectral_centroid.p if order else None,
        class_held_out=real.material_held_out if real else None,
        chance=real.chance if real else None,
    )
