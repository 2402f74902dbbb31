"""Command ``sets``: study of detectors on real recordings, and on the twin with other noise."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache, partial
from pathlib import Path

from firstcontact.contact import DETECTORS
from firstcontact.contact.detector_file import pretrained_detector
from firstcontact.core import (
    Dataset,
    FileError,
)
from firstcontact.core.quantity import SHORE_A
from firstcontact.core.text import percent
from firstcontact.jobs import Runner
from firstcontact.models import Touches
from firstcontact.models.alignment import detect_alignment
from firstcontact_lab.report.findings import Figure, PartResult, missing
from firstcontact_lab.report.page import Column, Page, Section, State
from firstcontact_lab.report.results import Field, SubjectResults
from firstcontact_lab.report.run import Job, run_steps
from firstcontact_lab.report.tables import (
    Cell,
    Row,
    Table,
    Value,
    matrix,
    optional,
    row_table,
)
from firstcontact_lab.study.detection_scores import (
    Delays,
    DetectionScores,
)
from firstcontact_lab.study.part import Part, Subjects
from firstcontact_lab.study.parts.short_windows import SHOWN_MS
from firstcontact_lab.study.parts.stiffness import STIFFNESS, score_by_time, time_figure
from firstcontact_lab.study.parts.stiffness import TABLES as STIFFNESS_TABLES
from firstcontact_lab.study.set_scores import (
    NoiseScores,
    RealSet,
    SetResults,
    noise_scorer,
    score_set,
)

SET = Field.optional("set", SetResults)
NOISE = Field.optional("noise", NoiseScores)


def run_sets(
    out: Path, sets: Sequence[RealSet], twin: Dataset, noises: Sequence[tuple[str, Dataset]]
) -> Subjects:
    names = [name for name, _ in noises]
    for name, dataset in noises:
        if names.count(name) > 1:
            raise FileError(f"two folders of --noises are called {name}: rename one")
        if dataset.layout != twin.layout:
            raise FileError(
                f"{name} of --noises has other channels or another sampling rate than --twin: "
                "simulate both in the same way"
            )
    scorer = cache(lambda: noise_scorer(twin))
    measured = {each.name: s for each in sets if each.study and (s := each.study[STIFFNESS])}

    def score_noise(name: str, dataset: Dataset) -> PartResult:
        return PartResult([NOISE(scorer()(dataset))])

    def score_recorded(recorded: RealSet) -> PartResult:
        results, left_out = score_set(recorded, twin)
        entries = [SET(results), *map(STIFFNESS, filter(None, [measured.get(recorded.name)]))]
        return PartResult(entries, left_out=left_out)

    def score_twin(runner: Runner) -> PartResult:
        contacts = detect_alignment(twin, pretrained_detector()).contacts
        found, reason = score_by_time(
            twin, SHORE_A, contacts, YARDSTICKS, Touches.SCORED_MS, 0, runner, with_levels=False
        )
        return missing(f"Twin: {reason}") if found is None else PartResult([STIFFNESS(found)])

    jobs = [Job(each.name, "set", "set", partial(score_recorded, each)) for each in sets]
    jobs += [
        Job(name, "noise", "noise", partial(score_noise, name, dataset)) for name, dataset in noises
    ]
    state = State(
        settings={"seed": 0},
        options={"verb": "sets"},
        parts={"noise": NOISE_PART},
        page=sets_page,
    )

    def all_jobs(runner: Runner) -> list[Job]:
        beside = Job(TWIN_CURVE, "set", "time", partial(score_twin, runner))
        return [*jobs, beside] if measured else jobs

    run_steps(out, state, 1, all_jobs)
    return {findings.name: findings.results for findings in state.findings}


_NOISE_ROWS: Sequence[Row[DetectionScores]] = (
    Row("pinches", lambda s: s.n),
    Row("placed within 3 ms", lambda s: s.pinch_success, "share"),
    Row("decided within 3 ms", lambda s: s.decided_within_3_ms, "share"),
    Row("false alarms a minute", lambda s: s.false_alarms_per_minute, "rate"),
    Row("delay, median", optional(lambda s: s.delay_ms, lambda d: d.median), "ms"),
    Row("95th percentile", optional(lambda s: s.delay_ms, lambda d: d.p95), "ms"),
)
_ERROR_ROWS: Sequence[Row[NoiseScores]] = (
    Row("15 ms: RMSE, Shore A", lambda s: s.rmse, "shore"),
    Row("unseen objects", lambda s: s.rmse_unseen, "shore"),
)


def _set_rows() -> list[Row[SubjectResults]]:
    def lookup(value: Callable[[SetResults], Value]) -> Callable[[SubjectResults], Value]:
        return optional(lambda results: results[SET], value)

    def contacts(scores: SetResults) -> str:
        some = scores.n < scores.pinches
        return f"{scores.n:,}" + (f" (of {scores.pinches:,} recordings)" if some else "")

    def classes(scores: SetResults) -> Value:
        shares = scores.class_held_out or {}
        return " / ".join(percent(shares[ms]) for ms in SHOWN_MS if ms in shares) or None

    def delay(value: Callable[[Delays], Value]) -> Callable[[SubjectResults], Value]:
        return optional(lambda r: None if (s := r[SET]) is None else s.delay_ms, value)

    return [
        Row("sensor", lookup(lambda s: s.sensor)),
        Row("rate", lookup(lambda s: s.rate_hz), "hz"),
        Row("front end", lookup(lambda s: s.front_end)),
        Row("contacts", lookup(contacts)),
        Row("label late by up to", lookup(lambda s: s.early_ms or None), "ms"),
        Row("found within 2 ms", lookup(lambda s: s.placed_2_ms), "share"),
        Row("early", lookup(lambda s: s.early_triggers)),
        Row(
            "false alarms a minute of noise",
            lookup(lambda s: s.noise_false_alarms_per_minute),
            "rate",
        ),
        Row("delay, median", delay(lambda d: d.median), "ms"),
        Row("delay, 95th percentile", delay(lambda d: d.p95), "ms"),
        Row("noise", lookup(lambda s: s.noise_seconds or None), "s"),
        Row("order of hardness: ρ", lookup(lambda s: s.order_rho), "rho"),
        Row("– its two-sided p", lookup(lambda s: s.order_p), "p"),
        Row(f"hardness class, material left out, {' / '.join(SHOWN_MS)} ms", lookup(classes)),
        Row("– constant prediction", lookup(lambda s: s.chance), "share"),
    ]


def overview(subjects: Subjects) -> Table:
    title = DETECTORS[DETECTORS.default].title
    sets = {name: results for name, results in subjects.items() if results[SET]}
    caption = (
        f"Contacts by the {title} detector, at the rate of the recordings. It was trained on the "
        "set's other specimens if there are some, otherwise on the twin. Early: contacts with a "
        "trigger more than 2 ms before the label. Delay: time from the label to the decision. "
        "Order: Spearman's correlation over materials between hardness and a score without "
        "training. Hardness class: balanced accuracy."
    )
    return row_table(_set_rows(), sets, caption)


def _detector_title(name: str) -> str:
    return DETECTORS[name].title if name in DETECTORS else name


def noise_tables(subjects: Subjects) -> list[Table | None]:
    noises = {name.replace("_", " "): results[NOISE] for name, results in subjects.items()}
    caption = (
        "Twin results: the same simulated pinches, with the modelled noise of the electronics, and "
        "with the noise of real sensors at rest. The noise of the motor is modelled in each. "
        "Detectors and the estimator were trained on other pinches of other rigs, with the "
        "modelled noise."
    )
    detection = matrix(
        caption,
        _NOISE_ROWS,
        [
            (Cell(f"{name}, {_detector_title(kind)}"), scores, False)
            for name, noise in noises.items()
            for kind, scores in (noise.detectors if noise else {}).items()
        ],
    )
    caption = "Errors of estimates at the contacts of the default detector."
    entries = [(Cell(name), noise, False) for name, noise in noises.items()]
    return [detection, matrix(caption, _ERROR_ROWS, entries)]


NOISE_PART = Part(
    "noise", "The twin with other noises", tables=lambda results: noise_tables({"here": results})
)


_SETS = (
    "No detector was tuned or trained on the data on which it is tested: if it was trained on the "
    "set, the tested specimen was left out."
)


#: Subject with the time curve of the twin, and the estimators that are compared over time.
TWIN_CURVE, YARDSTICKS = "twin", ("svm", "peak", "train_mean")
_STIFFNESS = (
    "Contacts with a known stiffness in N/mm, beside simulated pinches of known Shore A. Each "
    "session of either was held out in turn."
)


def stiffness_curves(subjects: Subjects) -> Figure | None:
    """Return a figure of errors over time, for the twin and all sets with known stiffness.

    Return None if no set has known stiffness.
    """
    found = {name: s for name, results in subjects.items() if (s := results[STIFFNESS])}
    return time_figure(found, YARDSTICKS) if set(found) - {TWIN_CURVE} else None


def _stiffness_sections(subjects: Subjects) -> list[Section]:
    curves = stiffness_curves(subjects)
    if curves is None:
        return []
    columns = [
        Column(name, [t for make in STIFFNESS_TABLES if (t := make(results))], [])
        for name, results in subjects.items()
        if results[STIFFNESS] and name != TWIN_CURVE
    ]
    return [Section("stiffness", "Known stiffness", _STIFFNESS, [curves], details=columns)]


def sets_page(state: State) -> Page:
    subjects = {findings.name: findings.results for findings in state.findings}
    table = overview(subjects)
    return Page(
        title="First contact: real sets",
        heading="First contact: real sets",
        intro="Recordings by others, with other sensors. A number is missing where a set does not "
        "permit it.",
        badges=["Real recordings", state.started, state.elapsed],
        sections=[
            *([Section("sets", "The sets", _SETS, table=table)] if table.lines else []),
            *_stiffness_sections(subjects),
        ],
        how=[("Time", [state.elapsed])],
        several=True,
    )
