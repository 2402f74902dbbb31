"""Detectors on real sets at their own rates: learned on the twin, or on the rest of the set."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from firstcontact.contact import (
    DETECTORS,
    Detector,
    cut_closings,
    find_onsets,
    latch,
    make_detector,
)
from firstcontact.core import Block, Contact, Dataset, InputError
from firstcontact.models import judged, quantiles
from firstcontact.signal import resample_dataset
from firstcontact_lab.report.results.sets import FinderFound, Found, Recorded, SetResults
from firstcontact_lab.study.set_folder import RealSet

#: How far from its label a contact may be placed, s.
WITHIN = 0.002
#: What a detector can have learned from: simulated pinches, or the set's other specimens.
TWIN, OTHERS, NOTHING = "twin", "others", "nothing"

Firsts = list[Contact | None]


def score_set(
    its: RealSet, twin: Dataset, say: Callable[[str], object] = lambda line: None
) -> SetResults:
    """Every detector on one set.

    Parameters
    ----------
    its
        The set.
    twin
        Simulated pinches to learn from; they are brought to the set's rate.
    say
        Told what is being done.
    """
    heard = cut_closings(its.dataset)
    known = np.array([p.first is not None for p in heard.pinches])
    labelled = heard.take(known) if known.any() else None
    detectors: dict[str, dict[str, Found]] = {}
    firsts: dict[tuple[str, str], Firsts] = {}
    if labelled is not None:
        learned = cut_closings(resample_dataset(twin, its.layout.rate))
        for name, kind in DETECTORS.items():
            ways = (TWIN, OTHERS) if kind.learns else (NOTHING,)
            for way in ways:
                say(f"{its.name}: {kind.title}, learned from {way}")
                try:
                    found, fitted = _judged(name, way, labelled, learned, its.early)
                except InputError as error:
                    say(f"{its.name}: {kind.title} left out: {error}")
                    continue
                firsts[name, way] = found
                scored = _scored(labelled, found, its, fitted)
                detectors.setdefault(name, {})[way] = scored
    main = DETECTORS.default
    able = [way for way in (OTHERS, TWIN, NOTHING) if (main, way) in firsts]
    results = _about(its, detectors, labelled)
    if not able or labelled is None:
        return results
    way = able[0]
    best = detectors[main][way]
    return replace(
        results,
        training=way,
        placed_2_ms=best.placed_2_ms,
        early_triggers=best.early_triggers,
        delay_ms=best.delay_ms,
        noise_false_alarms_per_minute=best.noise_false_alarms_per_minute,
        files=_by_file(its, labelled, firsts[main, way]),
        finder=_finder(its, labelled, firsts[main, way]),
    )


def _judged(
    name: str, way: str, labelled: Dataset, twin: Dataset, early: float
) -> tuple[Firsts, list[Detector]]:
    """First trigger of each pinch, by one that never heard its specimen; and all that did so."""
    fingers = labelled.layout.vibration_fingers

    def firsts(detector: Detector, some: Dataset) -> Firsts:
        return [next(iter(latch(v, fingers, set())), None) for v in judged(detector, some)]

    if way != OTHERS:
        detector = make_detector(name)
        detector = detector.fit(twin) if way == TWIN else detector
        return firsts(detector, labelled), [detector]
    out: Firsts = [None] * len(labelled)
    specimens = labelled.specimens
    fitted = []
    if len(np.unique(specimens)) < 2:
        raise InputError("the set has one specimen, and none is left to learn from")
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
    labelled: Dataset, firsts: Firsts, its: RealSet, detectors: Sequence[Detector]
) -> Found:
    places, delays = _against(labelled, firsts)
    good = _good(places, its.early)
    minutes = sum(len(b.data) for b in its.noise) / its.layout.rate / 60.0
    return Found(
        n=len(labelled),
        placed_2_ms=float(good.mean()),
        early_triggers=int((places < -(its.early + WITHIN)).sum()),
        late=int((places > WITHIN).sum()),
        missed=int(np.isnan(places).sum()),
        delay_ms=quantiles(1e3 * delays[good]) if good.any() else None,
        noise_false_alarms_per_minute=(
            max(_alarms(d, its.noise, its) for d in detectors) / minutes if its.noise else None
        ),
    )


def _against(
    labelled: Dataset, firsts: Sequence[Contact | None]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """How late each was placed and decided, s; NaN where it was missed."""
    rate = labelled.layout.rate
    out = np.full((2, len(labelled)), np.nan)
    for i, (pinch, found) in enumerate(zip(labelled.pinches, firsts, strict=True)):
        if found is not None and pinch.first is not None:
            at = pinch.first.sample
            out[:, i] = (found.sample - at) / rate, (found.decided - at) / rate
    return out[0], out[1]


def _good(places: NDArray[np.float64], early: float) -> NDArray[np.bool_]:
    with np.errstate(invalid="ignore"):
        return np.asarray((places >= -(early + WITHIN)) & (places <= WITHIN))


def _alarms(detector: Detector, noise: Sequence[Block], its: RealSet) -> int:
    """Runs of firing windows in unbroken noise."""
    alarms = 0
    for number, block in enumerate(noise):
        detector.start(its.layout)
        verdicts = detector.judge(Block(block.data, block.first_sample, number))
        fired = np.array(verdicts.fired.any(axis=1))
        fired[1:] &= ~fired[:-1].copy()
        alarms += int(fired.sum())
    return alarms


def _by_file(its: RealSet, labelled: Dataset, firsts: Firsts) -> dict[str, Recorded]:
    places, delays = _against(labelled, firsts)
    good = _good(places, its.early)
    out = {}
    for session in dict.fromkeys(labelled.sessions.tolist()):
        here = labelled.sessions == session
        out[session] = Recorded(
            front_end=its.front_end(session),
            n=int(here.sum()),
            placed_2_ms=float(good[here].mean()),
            early_triggers=int((places[here] < -(its.early + WITHIN)).sum()),
            delay_ms=quantiles(1e3 * delays[here & good]) if (here & good).any() else None,
        )
    return out


def _finder(its: RealSet, labelled: Dataset, firsts: Firsts) -> FinderFound:
    """The onset nearest to each label, and to the detector's first trigger."""
    from_label, from_detector = [], []
    rate = its.layout.rate
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
    there = np.abs(distances[np.isfinite(distances)])
    return FinderFound(
        placed_2_ms=float(_good(distances, its.early).mean()),
        from_label_ms=quantiles(1e3 * there) if len(there) else None,
        from_detector_ms=quantiles(np.array(from_detector)) if from_detector else None,
    )


def _about(
    its: RealSet, detectors: dict[str, dict[str, Found]], labelled: Dataset | None
) -> SetResults:
    """What is known of the set, with what a study of it found."""
    order = its.study.hardness_order if its.study else None
    real = next(iter((its.study.real or {}).values()), None) if its.study else None
    ends = list(dict.fromkeys(its.front_ends.values()))
    return SetResults(
        n=0 if labelled is None else len(labelled),
        sensor=", ".join(dict.fromkeys(str(c.sensor) for c in its.layout.vibration)),
        rate_hz=its.layout.rate,
        front_end=", ".join(ends) or "not said",
        pinches=len(its.dataset),
        materials=len(set(its.dataset.objects.tolist()) - {""}),
        early_ms=1e3 * its.early,
        noise_seconds=sum(len(b.data) for b in its.noise) / its.layout.rate,
        detectors=detectors or None,
        order_rho=order.spectral_centroid.rho if order else None,
        order_p=order.spectral_centroid.p if order else None,
        class_held_out=real.material_held_out if real else None,
        chance=real.chance if real else None,
    )
