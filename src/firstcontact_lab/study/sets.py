"""Report on the detectors on several sets of real recordings."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

from firstcontact.contact import DETECTORS
from firstcontact.core import Dataset, installed_versions, percent
from firstcontact.models import Delays
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
from firstcontact_lab.study.parts.short_windows import SHOWN_MS
from firstcontact_lab.study.set_folder import RealSet
from firstcontact_lab.study.set_scores import (
    NOTHING,
    OTHERS,
    TWIN,
    DetectorScores,
    FinderScores,
    Recorded,
    SetResults,
    score_set,
)

R = TypeVar("R")

SET = Field.optional("set", SetResults)
#: Training of a detector, in words.
_TRAINING = {
    TWIN: "the twin, resampled",
    OTHERS: "the set's other specimens",
    NOTHING: "learns nothing",
}
_PLACED = Row[Any]("found within 2 ms", lambda s: s.placed_2_ms, "share")
_EARLY = Row[Any]("early", lambda s: s.early_triggers)
_ALARMS = Row[DetectorScores](
    "false alarms a minute of noise", lambda s: s.noise_false_alarms_per_minute, "rate"
)


def _quantile_rows(
    median: str, p95: str, delays: Callable[[R], Delays | None]
) -> tuple[Row[R], Row[R]]:
    """Return two row definitions: median and 95th percentile of times, ms."""
    return (
        Row(median, optional(delays, lambda d: d.median), "ms"),
        Row(p95, optional(delays, lambda d: d.p95), "ms"),
    )


_DELAYS: Sequence[Row[Any]] = _quantile_rows(
    "delay, median", "delay, 95th percentile", lambda s: s.delay_ms
)
_DETECTOR_ROWS: Sequence[Row[DetectorScores]] = (
    Row("contacts", lambda s: s.n),
    _PLACED,
    _EARLY,
    Row("late", lambda s: s.late),
    Row("missed", lambda s: s.missed),
    _ALARMS,
    *_DELAYS,
)


def set_rows(subjects: Subjects) -> list[Row[SubjectResults]]:
    """Return the row definitions of a set: sensor, default detector, and hardness of materials."""

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
        *(lifted(row, "", default) for row in (_PLACED, _EARLY, _ALARMS, *_DELAYS)),
        Row("noise", lookup(lambda s: s.noise_seconds or None), "s"),
        Row("order of hardness: ρ", lookup(lambda s: s.order_rho), "rho"),
        Row("– its two-sided p", lookup(lambda s: s.order_p), "p"),
        Row(f"hardness class, material left out, {' / '.join(SHOWN_MS)} ms", lookup(classes)),
        Row("– constant prediction", lookup(lambda s: s.chance), "share"),
    ]


def overview(subjects: Subjects) -> Table:
    """Return a table with the sets side by side."""
    title = DETECTORS[DETECTORS.default].title
    sets = {name: results for name, results in subjects.items() if results[SET]}
    caption = (
        f"Contacts by the {title} detector, at the rate of the recordings. It was trained on the "
        "set's other specimens if there are some, otherwise on the twin. Early: contacts with a "
        "trigger more than 2 ms before the label. Delay: time from the label to the decision. "
        "Order: Spearman's correlation over materials between hardness and a score without "
        "training. Hardness class: balanced accuracy."
    )
    return row_table(set_rows(sets), sets, caption)


def _trainings_table(results: SubjectResults) -> Table | None:
    """Return a table of the scores of every detector, by its training data."""
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


_FINDER_ROWS: Sequence[Row[FinderScores]] = (
    Row("within 2 ms", lambda s: s.placed_2_ms, "share"),
    *_quantile_rows("from the label, median", "95th percentile", lambda s: s.from_label_ms),
    *_quantile_rows("from the detector's, median", "95th percentile", lambda s: s.from_detector_ms),
)


def _finder_table(results: SubjectResults) -> Table | None:
    """Return a table of the onset finder's scores. It also uses samples after a contact."""
    set_results = results[SET]
    caption = (
        "The onset finder that suggests marks for labelling, and looks ahead: share of the labels "
        "with an onset within 2 ms, and distance of onsets from the label and from the detector's "
        "contact."
    )
    finder = set_results.finder if set_results else None
    return matrix(caption, _FINDER_ROWS, [(Cell("onset finder"), finder, False)])


_FILE_ROWS: Sequence[Row[Recorded]] = (
    Row("front end", lambda s: s.front_end or None),
    Row("contacts", lambda s: s.n),
    _PLACED,
    _EARLY,
    *_quantile_rows("delay, median", "95th percentile", lambda s: s.delay_ms),
)


def _file_table(results: SubjectResults) -> Table | None:
    """Return a table of the default detector's scores on each recording."""
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
        "No detector was tuned or trained on the data on which it is tested: if it was trained on "
        "the set, the tested specimen was left out."
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
    """Score every set, and the twin with every noise. Write the report and ``results.json``."""
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
        intro="Recordings by others, with other sensors. A number is missing where a set does not "
        "permit it.",
        badges=["Real recordings", state.started, elapsed(state)],
        notice=notice(state),
        sections=[*opening, *sections(state.findings, SET_PARTS)],
        command=state.command,
        how=[("Time", [elapsed(state)])],
        versions=installed_versions(),
        several=True,
    ).html()
