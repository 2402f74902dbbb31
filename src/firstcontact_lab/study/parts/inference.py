"""Time of one estimate, on this machine and on the microcontroller."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Annotated

import msgspec
import numpy as np
from msgspec.structs import asdict, astuple

from firstcontact.core import InputError, Record
from firstcontact.core.files import read_regular
from firstcontact.core.installation import missing_modules
from firstcontact.core.jobs import Runner, one_thread
from firstcontact.core.physics import is_same_rate
from firstcontact.core.records import LONGEST, Name, read_record
from firstcontact.export.budget import microseconds
from firstcontact.models import (
    ESTIMATORS,
    LabelledTouches,
    LabelledWindows,
    Task,
    Touches,
    WindowModel,
    make_estimator,
)
from firstcontact.models.model_file import pretrained
from firstcontact.models.registry import window_estimators
from firstcontact.models.training import DURATION, Fit, fit_model
from firstcontact.models.training_runs import RIG_ESTIMATOR
from firstcontact_lab.report import names
from firstcontact_lab.report.findings import PartResult, missing
from firstcontact_lab.report.names import NETWORK_TITLES
from firstcontact_lab.report.results import Field, SubjectResults
from firstcontact_lab.report.tables import ABSENT, Cell, Row, Table, Value, lifted, matrix
from firstcontact_lab.study.part import Part, Step, StudySettings, Subject, Subjects, distinct
from firstcontact_lab.study.parts.anytime import conditioned_model, conditioning_contacts
from firstcontact_lab.study.timing import InferenceTime, time_calls, time_inference


class InferenceTimes(InferenceTime, frozen=True, kw_only=True):
    classification: InferenceTime | None = None


_Rate = Annotated[float, msgspec.Meta(gt=0)]


_Positive = Annotated[int, msgspec.Meta(gt=0)]


class BoardTime(Record, frozen=True, kw_only=True):
    estimator: Name
    task: Name
    samples: _Positive
    rate_hz: _Rate
    instructions: _Positive

    @property
    def signal_ms(self) -> float:
        """Duration of the samples that the form takes, ms."""
        return 1e3 * self.samples / self.rate_hz

    @property
    def microseconds(self) -> float:
        """Time of a prediction on the board, us."""
        return microseconds(self.instructions)


class _Row(msgspec.Struct):
    # The entry of a detector has no estimator. The entry of a model that is too large for the board
    # has no instructions.
    estimator: Name | None = None
    task: Name | None = None
    samples: _Positive | None = None
    rate_hz: _Rate | None = None
    instructions: _Positive | None = None


class _Board(msgspec.Struct):
    models: dict[Name, _Row]


def read_board(path: Path) -> dict[str, BoardTime]:
    remedy = "give the embedded.json of `make embedded` of this version"
    rows = read_record(read_regular(path, LONGEST), _Board, str(path), remedy).models
    times_by_model = {
        name: BoardTime(**asdict(row)) for name, row in rows.items() if None not in astuple(row)
    }
    if not times_by_model:
        raise InputError(f"{path} has no models whose instructions are counted: {remedy}")
    return times_by_model


#: Number of contacts for the network's timing, in turn.
ASKED = 100
#: Number of windows to train a slow estimator on before timing it.
SLOW_WINDOWS = 300


def inference(subject: Subject, settings: StudySettings, runner: Runner) -> PartResult:
    data = subject.windows(DURATION)
    blocks = data.take(~data.test)
    if len(np.unique(blocks.y)) < 2:
        return missing(
            "Inference time: windows of two Shore A levels or more are needed to train a model."
        )
    # The outputs of a slow estimator hardly change its time: one task is enough.
    jobs = [
        (model, task)
        for model, entry in window_estimators().items()
        if not entry.baseline and not missing_modules(entry.modules)
        for task in (entry.tasks[:1] if entry.slow else entry.tasks)
    ]
    timed: dict[str, dict[Task, InferenceTime]] = {}
    for (model, task), trained in zip(
        jobs, runner.map(_train, jobs, blocks, settings.seed), strict=True
    ):
        estimator = make_estimator(model, task, blocks.rate)
        # Timed in this process after all trainings, so that nothing else runs.
        with one_thread():
            reference = estimator.reference(trained, blocks.X, blocks.y)
            times = time_inference(trained, blocks.X, reference, settings.calls)
        timed.setdefault(model, {})[task] = times
    times_by_model = {
        model: InferenceTimes(**asdict(regression), classification=by_task.get(Task.CLASSIFICATION))
        if (regression := by_task.get(Task.REGRESSION))
        else InferenceTimes(**asdict(by_task[Task.CLASSIFICATION]))
        for model, by_task in timed.items()
    }
    board = read_board(Path(settings.board)) if settings.board else None
    running = _anytime(subject, settings)
    return PartResult([INFERENCE(times_by_model), ANYTIME_TIME(running), BOARD(board)])


def _anytime(subject: Subject, settings: StudySettings) -> InferenceTime | None:
    """Return the time of the network's first estimate; None if the network cannot predict."""
    model = pretrained()
    if not subject.detections or not is_same_rate(subject.dataset.layout.rate, model.rate):
        return None
    labelled = LabelledTouches.cut(subject.dataset, subject.starts)
    home = conditioning_contacts(labelled, subject)
    if home is None:
        return None
    adapted = subject.adapted or conditioned_model(RIG_ESTIMATOR.name, home, settings.seed)
    first = Touches.moments(model.rate)[0]
    inputs = [home.touches.take(np.array([k])).until(first) for k in range(min(len(home), ASKED))]
    with one_thread():
        return time_calls(adapted.model.predict, inputs, settings.calls)


def _train(job: tuple[str, Task], blocks: LabelledWindows, seed: int) -> WindowModel:
    """Return a briefly trained model. If training is slow, it learns from a part of the pinches."""
    model, task = job
    entry = ESTIMATORS.find(model)
    options = dict(entry.quick)
    if entry.slow:  # its inference time does not depend on the training data
        blocks = blocks.take(np.arange(0, len(blocks), max(1, len(blocks) // SLOW_WINDOWS)))
    return fit_model(Fit(model, task, blocks, blocks.X, seed, options))


INFERENCE = Field.optional("inference_us", dict[str, InferenceTimes])
ANYTIME_TIME = Field.optional("anytime_us", InferenceTime)
BOARD = Field.optional("board", dict[str, BoardTime])
#: Time of one window on a computer that the paper does not name (section IV).
PUBLISHED = {"svm": "< 1 ms", "cnn": "1.4 ms"}
#: Largest share of preempted calls, and largest load per core, at which times count. The
#: study's own workers make a load of one per core in the minute before.
MOST_PREEMPTED = 0.01
MOST_LOAD = 2.0

_P99 = Row[InferenceTime]("p99", lambda t: t.p99, "us")
_SPEEDUP = Row[InferenceTime]("faster than its training library", lambda t: t.speedup, "ratio")
_MEDIAN = Row[InferenceTime]("median", lambda t: t.p50, "us")
_TIMES = (
    _MEDIAN,
    _P99,
    Row[InferenceTime]("p99 with preempted calls", lambda t: t.p99_with_preempted, "us"),
    Row[InferenceTime](
        "training library, median", lambda t: None if t.reference is None else t.reference_p50, "us"
    ),
    _SPEEDUP,
)


def inference_table(results: SubjectResults) -> Table | None:
    times = results[INFERENCE]
    if not times:
        return None
    entries: list[tuple[Cell, InferenceTime | None, bool]] = []
    for name, time in times.items():
        title = names.estimator(name).title
        entries.append((Cell(title, _remarks(time)), time, False))
        classifier = time.classification
        if classifier:
            entries.append(
                (Cell(f"{title}, classification", _remarks(classifier)), classifier, False)
            )
    timed = [time for _, time, _ in entries if time]
    busiest = max(timed, key=lambda time: time.load)
    caption = (
        f"One window at a time, one thread, this machine; {min(t.calls for t in timed):,} calls or "
        "more each. Calls that another process interrupted are not included, except where stated. "
        f"Load of the machine: {busiest.load:.1f} on {busiest.cores} cores."
    )
    return matrix(caption, (_MEDIAN, _P99, _SPEEDUP), entries)


def _remarks(time: InferenceTime) -> str:
    vectors = "" if time.support_vectors is None else f"{time.support_vectors:,} support vectors"
    preempted = f"{time.preempted:,} calls preempted" if time.preempted else ""
    return "; ".join(filter(None, (vectors, preempted, time.reference)))


_CAPTION = (
    "Time from the contact to an estimate: samples, and computing on the emulated Cortex-M7 "
    "(1.5 cycles per counted instruction at 600 MHz are assumed) or on this machine (p99). The "
    "decision on the contact, cable and packets are not included. Of models with several forms, "
    "the cheapest and the most expensive are shown."
)


def board_table(results: SubjectResults) -> Table | None:
    board = results[BOARD]
    if not board:
        return None

    def local(form: str) -> Value:
        us = _local_p99(results, board[form])
        return None if us is None else board[form].signal_ms + 1e-3 * us

    columns: Sequence[Row[str]] = (
        Row("Samples", lambda form: board[form].samples),
        Row("Signal", lambda form: board[form].signal_ms, "ms"),
        Row("Instructions", lambda form: board[form].instructions),
        Row("Arithmetic", lambda form: board[form].microseconds, "us"),
        Row(
            "On the board",
            lambda form: board[form].signal_ms + 1e-3 * board[form].microseconds,
            "ms",
        ),
        Row("This machine, no cable", local, "ms"),
    )
    entries = [(Cell(_form_title(board[form]), form), form, False) for form in _ends(board)]
    return matrix(_CAPTION, columns, entries)


def _form_title(time: BoardTime) -> str:
    title = NETWORK_TITLES.get(time.estimator, names.estimator(time.estimator).title)
    return f"{title}, classification" if time.task == Task.CLASSIFICATION else title


def _ends(board: Mapping[str, BoardTime]) -> list[str]:
    """Return the names of each model's cheapest and most expensive form, in the given order."""
    models: dict[tuple[str, str], list[str]] = {}
    for form, time in board.items():
        models.setdefault((time.estimator, time.task), []).append(form)
    ends = {
        end(forms, key=lambda form: board[form].instructions)
        for forms in models.values()
        for end in (min, max)
    }
    return [form for form in board if form in ends]


def _local_p99(results: SubjectResults, time: BoardTime) -> float | None:
    """Return the 99th percentile of the full model's time on this machine, us."""
    network = results[ANYTIME_TIME]
    if time.estimator in NETWORK_TITLES:
        return None if network is None else network.p99
    times = (results[INFERENCE] or {}).get(time.estimator)
    if times is not None and time.task == Task.CLASSIFICATION:
        return None if times.classification is None else times.classification.p99
    return None if times is None else times.p99


def _find_times(name: str) -> Callable[[SubjectResults], InferenceTimes | None]:
    return lambda results: (results[INFERENCE] or {}).get(name)


def _find_classifier(name: str) -> Callable[[SubjectResults], InferenceTime | None]:
    find = _find_times(name)
    return lambda results: times.classification if (times := find(results)) else None


def _rows(subjects: Subjects) -> list[Row[SubjectResults]]:
    def load(results: SubjectResults) -> Value:
        times = next(iter((results[INFERENCE] or {}).values()), None)
        return None if times is None else times.load

    times = [t for results in subjects.values() for t in (results[INFERENCE] or {}).values()]
    note = "not comparable: machine too busy" if _busy(times) else "not comparable: other computer"
    rows = [Row("Load of the machine meanwhile", load, "rate")]
    scored = distinct(name for r in subjects.values() for name in r[INFERENCE] or {})
    for name in names.estimators(distinct([*ESTIMATORS.names, *scored]), True):
        title = names.estimator(name).title
        rows += [
            lifted(
                row,
                f"{title}, one window: ",
                _find_times(name),
                PUBLISHED.get(name, ABSENT) if row is _P99 else ABSENT,
                note=(lambda results: note) if row is _P99 and name in PUBLISHED else None,
            )
            for row in _TIMES
        ]
        rows += [
            lifted(row, f"{title} classifier, one window: ", _find_classifier(name))
            for row in (_P99, _SPEEDUP)
        ]
    return rows


def _busy(times: Sequence[InferenceTimes]) -> bool:
    """Return True if other programs interrupted too many calls, or the load was too high."""
    preempted, calls = sum(t.preempted for t in times), sum(t.calls for t in times)
    return preempted > MOST_PREEMPTED * calls or any(
        time.load > MOST_LOAD * time.cores for time in times
    )


PART = Part(
    "time",
    "Time of one estimate",
    [Step("inference time", inference, late=True, cost=10)],
    tables=[inference_table, board_table],
    rows=_rows,
    columns=("median",),
)
