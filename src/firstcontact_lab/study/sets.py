"""Study of detectors on several sets of real recordings, and on the twin with other noise."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache, partial
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from firstcontact.contact import DETECTORS, make_detector
from firstcontact.core import Dataset, Record
from firstcontact.core.jobs import Serial
from firstcontact.core.text import percent
from firstcontact.models import ESTIMATORS, Task
from firstcontact.models.alignment import detect_alignment, found_as_live
from firstcontact.models.training import DURATION, Fit, fit_model, labelled_windows
from firstcontact_lab.report.findings import PartResult, State
from firstcontact_lab.report.page import Page, Section
from firstcontact_lab.report.results import Field, SubjectResults
from firstcontact_lab.report.run import Job, run_steps
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
from firstcontact_lab.study.detection_scores import Delays, DetectionScores, score_detector
from firstcontact_lab.study.part import Part, Subjects
from firstcontact_lab.study.parts.short_windows import SHOWN_MS
from firstcontact_lab.study.set_scores import (
    OTHERS,
    TWIN,
    UNTRAINED,
    DetectorScores,
    RealSet,
    SetResults,
    score_set,
)

R = TypeVar("R")

#: Header text that names the noise of the pinches (``simulate --noise``).
SAID = "noise of "
_TRAINING = {
    TWIN: "the twin, resampled",
    OTHERS: "the set's other specimens",
    UNTRAINED: "learns nothing",
}


class NoiseScores(Record, frozen=True, kw_only=True):
    noise: str
    detectors: dict[str, DetectionScores]
    estimator: str
    estimated: int
    rmse: float | None = None
    rmse_unseen: float | None = None


SET = Field.optional("set", SetResults)
NOISE = Field.optional("noise", NoiseScores)


def run_sets(
    out: Path,
    sets: Sequence[RealSet],
    twin: Dataset,
    noises: Sequence[tuple[str, Dataset]],
) -> dict[str, SubjectResults]:
    scorer = cache(lambda: noise_scorer(twin))

    def score_noise(name: str, dataset: Dataset) -> PartResult:
        return PartResult([NOISE(scorer()(dataset))])

    def score_recorded(recorded: RealSet) -> PartResult:
        results, left_out = score_set(recorded, twin)
        return PartResult([SET(results)], left_out=left_out)

    jobs = [Job(each.name, "set", "set", partial(score_recorded, each)) for each in sets]
    jobs += [
        Job(name, "noise", "noise", partial(score_noise, name, dataset)) for name, dataset in noises
    ]
    state = State(
        settings={"seed": 0},
        options={"verb": "sets"},
        parts={"set": SET_PART, "noise": NOISE_PART},
        page=sets_page,
    )
    run_steps(out, state, 1, lambda runner: jobs)
    return {findings.name: findings.results for findings in state.findings}


def noise_scorer(twin: Dataset) -> Callable[[Dataset], NoiseScores]:
    """Train detectors and an estimator on the twin. Return a function that scores other pinches."""
    detectors = {name: make_detector(name).fit(twin) for name in DETECTORS}
    main = detectors[DETECTORS.default]
    contacts = found_as_live(twin, main, 0, Serial())
    windows = labelled_windows(twin, contacts.contacts, DURATION, twin.shore_a)
    learn = windows.take(~windows.test)
    model = fit_model(Fit(ESTIMATORS.default, Task.REGRESSION, learn, learn.X[:0], 0))

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
            rmse=_root(squares[~windows.test]),
            rmse_unseen=_root(squares[windows.test]),
        )

    return score


def _root(squares: NDArray[np.float64]) -> float | None:
    return float(np.sqrt(squares.mean())) if len(squares) else None


def _quantile_rows(
    median: str, p95: str, delays: Callable[[R], Delays | None]
) -> tuple[Row[R], Row[R]]:
    """Return two row definitions: median and 95th percentile of times, ms."""
    return (
        Row(median, optional(delays, lambda d: d.median), "ms"),
        Row(p95, optional(delays, lambda d: d.p95), "ms"),
    )


_PLACED = Row[Any]("found within 2 ms", lambda s: s.placed_2_ms, "share")
_EARLY = Row[Any]("early", lambda s: s.early_triggers)
_ALARMS = Row[DetectorScores](
    "false alarms a minute of noise", lambda s: s.noise_false_alarms_per_minute, "rate"
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
_NOISE_ROWS: Sequence[Row[DetectionScores]] = (
    Row("pinches", lambda s: s.n),
    Row("placed within 3 ms", lambda s: s.pinch_success, "share"),
    Row("decided within 3 ms", lambda s: s.decided_within_3_ms, "share"),
    Row("false alarms a minute", lambda s: s.false_alarms_per_minute, "rate"),
    *_quantile_rows("delay, median", "95th percentile", lambda s: s.delay_ms),
)
_ERROR_ROWS: Sequence[Row[NoiseScores]] = (
    Row("15 ms: RMSE, Shore A", lambda s: s.rmse, "shore"),
    Row("unseen objects", lambda s: s.rmse_unseen, "shore"),
)


def set_rows(subjects: Subjects) -> list[Row[SubjectResults]]:
    def lookup(value: Callable[[SetResults], Value]) -> Callable[[SubjectResults], Value]:
        return optional(lambda results: results[SET], value)

    def contacts(scores: SetResults) -> str:
        some = scores.n < scores.pinches
        return f"{scores.n:,}" + (f" (of {scores.pinches:,} recordings)" if some else "")

    def classes(scores: SetResults) -> Value:
        shares = scores.class_held_out or {}
        return " / ".join(percent(shares[ms]) for ms in SHOWN_MS if ms in shares) or None

    def default(results: SubjectResults) -> DetectorScores | None:
        scores = results[SET]
        if scores is None or scores.training is None:
            return None
        return (scores.detectors or {})[DETECTORS.default][scores.training]

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


def _detector_title(name: str) -> str:
    return DETECTORS[name].title if name in DETECTORS else name


def _trainings_table(results: SubjectResults) -> Table | None:
    scores = results[SET]
    entries = [
        (Cell(_detector_title(name), _TRAINING[training]), entry, False)
        for name, trainings in ((scores and scores.detectors) or {}).items()
        for training, entry in trainings.items()
    ]
    return matrix("Every detector, by its training.", _DETECTOR_ROWS, entries)


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


SET_PART = Part(
    "set",
    "Detectors on each set",
    text=lambda subjects: (
        "No detector was tuned or trained on the data on which it is tested: if it was trained on "
        "the set, the tested specimen was left out."
    ),
    tables=[_trainings_table],
    rows=set_rows,
)
NOISE_PART = Part(
    "noise", "The twin with other noises", tables=lambda results: noise_tables({"here": results})
)


def sets_page(state: State) -> Page:
    table = overview({findings.name: findings.results for findings in state.findings})
    return Page(
        title="First contact: real sets",
        heading="First contact: real sets",
        intro="Recordings by others, with other sensors. A number is missing where a set does not "
        "permit it.",
        badges=["Real recordings", state.started, state.elapsed],
        sections=[Section("sets", "The sets", "", table=table)] if table.lines else [],
        how=[("Time", [state.elapsed])],
        several=True,
    )
