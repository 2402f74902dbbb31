"""Detectors on real sets at their own rates: learned on the twin, or on the rest of the set."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

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
from firstcontact.core import (
    Block,
    Contact,
    Dataset,
    InputError,
    Record,
    installed_versions,
    percent,
)
from firstcontact.models import Delays, judged, quantiles
from firstcontact.signal import resample_dataset
from firstcontact_lab.report.findings import Findings, PartResult
from firstcontact_lab.report.folder import sole_use
from firstcontact_lab.report.page import Column, Page, Section
from firstcontact_lab.report.results import Field, SubjectResults
from firstcontact_lab.report.state import State
from firstcontact_lab.report.tables import (
    Cell,
    Row,
    Table,
    Value,
    lifted,
    matrix,
    optional,
    row_table,
)
from firstcontact_lab.study._protocol import Job, run
from firstcontact_lab.study.noises import NOISE, NOISE_PART, NoiseScorer
from firstcontact_lab.study.page import elapsed, notice, sections
from firstcontact_lab.study.part import Part, Subjects
from firstcontact_lab.study.parts.hardness import HARDNESS
from firstcontact_lab.study.parts.short_windows import REAL, SHOWN_MS
from firstcontact_lab.study.set_folder import RealSet

#: How far from its label a contact may be placed, s.
WITHIN = 0.002
#: What a detector can have learned from: simulated pinches, or the set's other specimens.
TWIN, OTHERS, NOTHING = "twin", "others", "nothing"

Firsts = list[Contact | None]


class DetectorScores(Record, frozen=True, kw_only=True):
    """Scores of a detector on recordings at their own rate.

    Parameters
    ----------
    n
        Labelled contacts.
    placed_2_ms
        Share whose first trigger places the contact within 2 ms of its label (and of what
        a label that comes from a trigger may be late).
    early_triggers, late, missed
        Contacts whose first trigger is placed more than 2 ms too early, or too late, and those
        without one.
    delay_ms
        From the label to the sample that decided, over those within 2 ms.
    noise_false_alarms_per_minute
        In recordings of the set's own noise, of the worst of the trainings; None where it has
        none.
    """

    n: int
    placed_2_ms: float
    early_triggers: int
    late: int
    missed: int
    delay_ms: Delays | None = None
    noise_false_alarms_per_minute: float | None = None


class FinderScores(Record, frozen=True, kw_only=True):
    """Distances of onsets from the look-ahead finder to labels and to detected contacts.

    Parameters
    ----------
    placed_2_ms
        Share of the labelled contacts with an onset of the finder within 2 ms.
    from_label_ms, from_detector_ms
        Median and 95th percentile of the distance, ms.
    """

    placed_2_ms: float
    from_label_ms: Delays | None = None
    from_detector_ms: Delays | None = None


class Recorded(Record, frozen=True, kw_only=True):
    """One file of a set, by the detector that the set is scored with."""

    front_end: str
    n: int
    placed_2_ms: float
    early_triggers: int
    delay_ms: Delays | None = None


class SetResults(Record, frozen=True, kw_only=True):
    """Results of one set.

    Parameters
    ----------
    n, placed_2_ms, early_triggers, delay_ms, noise_false_alarms_per_minute
        Of the default detector with ``training``; see :class:`DetectorScores`.
    sensor, rate_hz, front_end
        What it was recorded with.
    training
        What that detector had learned from, a key of ``detectors``' entries.
    early_ms
        How much earlier than its label a contact may be.
    noise_seconds
        How much noise was listened to.
    detectors
        By detector, and by what it had learned from: the ``twin``, or the set's ``others``, with
        the tested specimen left out.
    files
        By recording, of the same detector and training.
    finder
        Of the onset finder, which looks ahead.
    order_rho, order_p
        Of hardness, by a score that nothing was fitted to.
    class_held_out
        Balanced accuracy of the hardness class with the material held out, by length in ms.
    chance
        Balanced accuracy of any constant prediction: all score the same.
    """

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
    """Every detector on one set.

    Parameters
    ----------
    recorded_set
        The set.
    twin
        Simulated pinches to learn from; they are brought to the set's rate.
    say
        Told what is being done.
    """
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
                say(f"{recorded_set.name}: {kind.title}, learned from {training}")
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
    """First trigger of each pinch, by one that never heard its specimen; and all that did so."""
    fingers = labelled.layout.vibration_fingers

    def firsts(detector: Detector, pinches: Dataset) -> Firsts:
        return [next(iter(latch(v, fingers, set())), None) for v in judged(detector, pinches)]

    if training != OTHERS:
        detector = make_detector(name)
        detector = detector.fit(twin) if training == TWIN else detector
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
    labelled: Dataset, firsts: Firsts, recorded_set: RealSet, detectors: Sequence[Detector]
) -> DetectorScores:
    places, delays = _against(labelled, firsts)
    good = _good(places, recorded_set.early)
    minutes = sum(len(b.data) for b in recorded_set.noise) / recorded_set.layout.rate / 60.0
    return DetectorScores(
        n=len(labelled),
        placed_2_ms=float(good.mean()),
        early_triggers=int((places < -(recorded_set.early + WITHIN)).sum()),
        late=int((places > WITHIN).sum()),
        missed=int(np.isnan(places).sum()),
        delay_ms=quantiles(1e3 * delays[good]) if good.any() else None,
        noise_false_alarms_per_minute=(
            max(_alarms(d, recorded_set.noise, recorded_set) for d in detectors) / minutes
            if recorded_set.noise
            else None
        ),
    )


def _against(
    labelled: Dataset, firsts: Sequence[Contact | None]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the delay of each placement and decision, s; NaN where the contact was missed."""
    rate = labelled.layout.rate
    out = np.full((2, len(labelled)), np.nan)
    for i, (pinch, results) in enumerate(zip(labelled.pinches, firsts, strict=True)):
        if results is not None and pinch.first is not None:
            at = pinch.first.sample
            out[:, i] = (results.sample - at) / rate, (results.decided - at) / rate
    return out[0], out[1]


def _good(places: NDArray[np.float64], early: float) -> NDArray[np.bool_]:
    with np.errstate(invalid="ignore"):
        return np.asarray((places >= -(early + WITHIN)) & (places <= WITHIN))


def _alarms(detector: Detector, noise: Sequence[Block], recorded_set: RealSet) -> int:
    """Count the runs of firing windows in unbroken noise."""
    alarms = 0
    for number, block in enumerate(noise):
        detector.start(recorded_set.layout)
        verdicts = detector.judge(Block(block.data, block.first_sample, number))
        fired = np.array(verdicts.fired.any(axis=1))
        fired[1:] &= ~fired[:-1].copy()
        alarms += int(fired.sum())
    return alarms


def _by_file(recorded_set: RealSet, labelled: Dataset, firsts: Firsts) -> dict[str, Recorded]:
    places, delays = _against(labelled, firsts)
    good = _good(places, recorded_set.early)
    out = {}
    for session in dict.fromkeys(labelled.sessions.tolist()):
        in_session = labelled.sessions == session
        out[session] = Recorded(
            front_end=recorded_set.front_end(session),
            n=int(in_session.sum()),
            placed_2_ms=float(good[in_session].mean()),
            early_triggers=int((places[in_session] < -(recorded_set.early + WITHIN)).sum()),
            delay_ms=quantiles(1e3 * delays[in_session & good])
            if (in_session & good).any()
            else None,
        )
    return out


def _finder(recorded_set: RealSet, labelled: Dataset, firsts: Firsts) -> FinderScores:
    """Score the onsets nearest to each label and to the detector's first trigger."""
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
    """Return the results of a set, with results from a study of the same set."""
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


SET = Field.optional("set", SetResults)
#: Training of a detector, in words.
_TRAINING = {
    TWIN: "the twin, resampled",
    OTHERS: "the set's other specimens",
    NOTHING: "learns nothing",
}
_PLACED = Row[DetectorScores]("found within 2 ms", lambda s: s.placed_2_ms, "share")
_EARLY = Row[DetectorScores]("early", lambda s: s.early_triggers)
_DELAY = Row[DetectorScores](
    "delay, median", lambda s: s.delay_ms.median if s.delay_ms else None, "ms"
)
_DELAY_P95 = Row[DetectorScores](
    "delay, 95th percentile", lambda s: s.delay_ms.p95 if s.delay_ms else None, "ms"
)
_ALARMS = Row[DetectorScores](
    "false alarms a minute of noise", lambda s: s.noise_false_alarms_per_minute, "rate"
)
_DETECTOR_ROWS: Sequence[Row[DetectorScores]] = (
    Row("contacts", lambda s: s.n),
    _PLACED,
    _EARLY,
    Row("late", lambda s: s.late),
    Row("missed", lambda s: s.missed),
    _ALARMS,
    _DELAY,
    _DELAY_P95,
)


def set_rows(subjects: Subjects) -> list[Row[SubjectResults]]:
    """Return the rows of a set: sensor, default detector, order and class of hardness."""

    def lookup(value: Callable[[SetResults], Value]) -> Callable[[SubjectResults], Value]:
        return optional(lambda results: results[SET], value)

    def contacts(set_results: SetResults) -> str:
        recordings = (
            f" (of {set_results.pinches:,} recordings)"
            if set_results.n < set_results.pinches
            else ""
        )
        return f"{set_results.n:,}{recordings}"

    def classes(set_results: SetResults) -> Value:
        shares = set_results.class_held_out or {}
        return " / ".join(percent(shares[ms]) for ms in SHOWN_MS if ms in shares) or None

    def default(results: SubjectResults) -> DetectorScores | None:
        set_results = results[SET]
        if set_results is None or set_results.training is None:
            return None
        return (set_results.detectors or {})[DETECTORS.default][set_results.training]

    return [
        Row("sensor", lookup(lambda s: s.sensor)),
        Row("rate", lookup(lambda s: s.rate_hz), "hz"),
        Row("front end", lookup(lambda s: s.front_end)),
        Row("contacts", lookup(contacts)),
        Row("label late by up to", lookup(lambda s: s.early_ms or None), "ms"),
        *(lifted(row, "", default) for row in (_PLACED, _EARLY, _ALARMS, _DELAY, _DELAY_P95)),
        Row("noise", lookup(lambda s: s.noise_seconds or None), "s"),
        Row("order of hardness: ρ", lookup(lambda s: s.order_rho), "rho"),
        Row("– its two-sided p", lookup(lambda s: s.order_p), "p"),
        Row(f"class, material left out, {' / '.join(SHOWN_MS)} ms", lookup(classes)),
        Row("– constant prediction", lookup(lambda s: s.chance), "share"),
    ]


def overview(subjects: Subjects) -> Table:
    """Return the sets side by side."""
    title = DETECTORS[DETECTORS.default].title
    sets = {name: results for name, results in subjects.items() if results[SET]}
    caption = (
        f"Contacts by the {title} detector, at the rate of the recordings; it learned from the "
        "set's other specimens where there are some. Early: contacts with a trigger more than 2 ms "
        "before the label. Delay: from the label to the decision. Order: Spearman over materials "
        "of a score that nothing was fitted to. Class: balanced accuracy of the hardness class."
    )
    return row_table(set_rows(sets), sets, caption)


def _trainings_table(results: SubjectResults) -> Table | None:
    """Return the scores of every detector and training."""
    set_results = results[SET]
    entries = [
        (
            Cell(DETECTORS[name].title if name in DETECTORS else name, _TRAINING[training]),
            scores,
            False,
        )
        for name, ways in ((set_results and set_results.detectors) or {}).items()
        for training, scores in ways.items()
    ]
    return matrix("Every detector, by its training.", _DETECTOR_ROWS, entries)


def _of_detector(quantile: str) -> Callable[[FinderScores], Value]:
    return lambda s: getattr(s.from_detector_ms, quantile, None)


_FINDER_ROWS: Sequence[Row[FinderScores]] = (
    Row("within 2 ms", lambda s: s.placed_2_ms, "share"),
    Row(
        "from the label, median",
        lambda s: s.from_label_ms.median if s.from_label_ms else None,
        "ms",
    ),
    Row("95th percentile", lambda s: s.from_label_ms.p95 if s.from_label_ms else None, "ms"),
    Row(
        "from the detector's, median",
        _of_detector("median"),
        "ms",
    ),
    Row("95th percentile", _of_detector("p95"), "ms"),
)


def _finder_table(results: SubjectResults) -> Table | None:
    """Return the distances of the onset finder, which may look ahead."""
    set_results = results[SET]
    caption = (
        "The onset finder that labelling starts from, which looks ahead: share of the labels with "
        "an onset within 2 ms, and distance of onsets from the label and from the detector's."
    )
    finder = set_results.finder if set_results else None
    return matrix(caption, _FINDER_ROWS, [(Cell("onset finder"), finder, False)])


_FILE_ROWS: Sequence[Row[Recorded]] = (
    Row("front end", lambda s: s.front_end or None),
    Row("contacts", lambda s: s.n),
    Row("found within 2 ms", lambda s: s.placed_2_ms, "share"),
    Row("early", lambda s: s.early_triggers),
    Row("delay, median", lambda s: s.delay_ms.median if s.delay_ms else None, "ms"),
    Row("95th percentile", lambda s: s.delay_ms.p95 if s.delay_ms else None, "ms"),
)


def _file_table(results: SubjectResults) -> Table | None:
    """Return the scores of each recording by the default detector."""
    set_results = results[SET]
    if not set_results or not set_results.files:
        return None
    entries = [(Cell(session), scores, False) for session, scores in set_results.files.items()]
    return matrix(
        f"Each file; {_TRAINING.get(set_results.training or '', '')}.", _FILE_ROWS, entries
    )


SET_PART = Part(
    "set",
    "Detectors on each set",
    (),
    lambda subjects: (
        "Nothing was tuned on what is tested here: a detector that learned from the set had the "
        "tested specimen left out."
    ),
    [_trainings_table, _finder_table, _file_table],
    set_rows,
)


SET_PARTS: dict[str, Part] = {"set": SET_PART, "noise": NOISE_PART}


def run_sets(
    out: Path,
    sets: Sequence[RealSet],
    twin: Dataset,
    noises: Sequence[tuple[str, Dataset]],
    command: str,
    say: Callable[[str], object],
) -> dict[str, SubjectResults]:
    """Score every set and the twin over every noise; write the report and ``results.json``.

    Parameters
    ----------
    out
        Folder of the two files.
    sets
        Recorded sets.
    twin
        Simulated pinches for training.
    noises
        Name and pinches of the twin over other noises.
    command
        Command line, for the report.
    say
        Called with the progress.

    Returns
    -------
    dict
        Results by subject.
    """
    scorers: list[NoiseScorer] = []

    def score_noise(name: str, dataset: Dataset) -> PartResult:
        if not scorers:
            scorers.append(NoiseScorer(twin, say=say))
        return PartResult([NOISE(scorers[0].score(name, dataset))])

    def score_recorded(recorded: RealSet) -> PartResult:
        return PartResult([SET(score_set(recorded, twin, say))])

    jobs = [
        Job(recorded.name, "set", "set", partial(score_recorded, recorded)) for recorded in sets
    ]
    jobs += [
        Job(name, "noise", "noise", partial(score_noise, name, recorded_set))
        for name, recorded_set in noises
    ]
    findings = [Findings(job.subject) for job in jobs]
    titles = [f"{job.subject}: {job.title}" for job in jobs]
    options = {"verb": "sets"}
    state = State(command, {"seed": 0}, False, findings, titles, options=options)
    with sole_use(out, options):
        run(jobs, state, out, page=sets_page)
    return {recorded_set.name: recorded_set.results for recorded_set in findings}


def sets_page(state: State) -> str:
    """Return the report of several sets, HTML."""
    subjects = {findings.name: findings.results for findings in state.findings}
    table = overview(subjects)
    opening = [Section("sets", "The sets", "", [Column("", [table], [])])] if table.lines else []
    return Page(
        title="First contact: real sets",
        heading="First contact: real sets",
        intro="Recordings of others, with other sensors. Numbers that are missing are not in that "
        "set.",
        badges=["Real recordings", state.started, elapsed(state)],
        notice=notice(state),
        sections=[*opening, *sections(state.findings, SET_PARTS)],
        command=state.command,
        how=[("Time", [elapsed(state)])],
        versions=installed_versions(),
        several=True,
    ).html()
