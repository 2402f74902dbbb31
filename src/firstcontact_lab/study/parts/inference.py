"""Study part ``inference``: computing time of one estimate on this computer.

For comparison, the training library also computes the estimate.
"""

from __future__ import annotations

import os
import resource
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from msgspec.structs import asdict, replace
from numpy.typing import NDArray

from firstcontact.core import Record
from firstcontact.core.installation import missing_modules
from firstcontact.core.physics import is_same_rate
from firstcontact.core.text import counted
from firstcontact.jobs import Runner
from firstcontact.jobs.runners import one_thread
from firstcontact.models import ESTIMATORS, Task, Touches, WindowModel
from firstcontact.models.labelled_data import DURATION, LabelledTouches, LabelledWindows
from firstcontact.models.model_file import pretrained
from firstcontact.models.registry import window_estimators
from firstcontact.models.training import fit_model
from firstcontact.models.training_runs import RIG_ESTIMATOR
from firstcontact_lab.report import names
from firstcontact_lab.report.findings import PartResult, missing
from firstcontact_lab.report.results import Field, SubjectResults
from firstcontact_lab.report.tables import ABSENT, Cell, Row, Table, Value, matrix, row_for_results
from firstcontact_lab.study.part import Part, Step, StudySettings, Subject, Subjects, distinct
from firstcontact_lab.study.parts.anytime import conditioned_model, conditioning_contacts

#: Number of calls before the measurement, which fill caches.
WARM_UP = 200

Call = Callable[[Any], object]


@dataclass(frozen=True, slots=True, eq=False)
class Timed:
    """Durations of single calls, µs, and a mask of the calls that were interrupted."""

    microseconds: NDArray[np.float64]
    preempted: NDArray[np.bool_]

    @property
    def uninterrupted(self) -> NDArray[np.float64]:
        """Durations of the uninterrupted calls, µs. If all were interrupted, of all calls."""
        return self.microseconds if self.preempted.all() else self.microseconds[~self.preempted]


def measure_durations(call: Call, windows: Sequence[Any] | NDArray[Any], calls: int) -> Timed:
    """Measure the durations of ``calls`` single calls, each with one of the windows in turn.

    Earlier calls, which are not measured, fill the caches.
    """
    for i in range(min(WARM_UP, calls)):
        call(windows[i % len(windows)])
    spent = np.empty(calls)
    preempted = np.zeros(calls, dtype=np.bool_)
    # Preemptions of this thread alone, if the system counts them.
    whose = getattr(resource, "RUSAGE_THREAD", resource.RUSAGE_SELF)
    switches = resource.getrusage(whose).ru_nivcsw
    for i in range(calls):
        window = windows[i % len(windows)]
        began = time.perf_counter_ns()
        call(window)
        spent[i] = time.perf_counter_ns() - began
        before, switches = switches, resource.getrusage(whose).ru_nivcsw
        preempted[i] = switches > before
    return Timed(spent / 1e3, preempted)


class InferenceTime(Record, frozen=True, kw_only=True):
    """Computing time of one prediction on one thread, µs."""

    p50: float
    p99: float
    p99_with_preempted: float
    calls: int
    preempted: int
    load: float
    cores: int
    support_vectors: int | None = None


def time_calls(call: Call, inputs: Sequence[Any] | NDArray[Any], calls: int) -> InferenceTime:
    """Measure the computing time of single calls on one thread, each with one input in turn."""
    import threadpoolctl

    load = os.getloadavg()[0]  # runnable processes in the last minute
    with threadpoolctl.threadpool_limits(1):
        times = measure_durations(call, inputs, calls)
    return InferenceTime(
        p50=float(np.percentile(times.uninterrupted, 50)),
        p99=float(np.percentile(times.uninterrupted, 99)),
        p99_with_preempted=float(np.percentile(times.microseconds, 99)),
        calls=calls,
        preempted=int(times.preempted.sum()),
        load=load,
        cores=os.cpu_count() or 1,
    )


class InferenceTimes(InferenceTime, frozen=True, kw_only=True):
    classification: InferenceTime | None = None


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
        jobs, runner.map(_train_briefly, jobs, blocks, settings.seed), strict=True
    ):
        # Timed in this process after all trainings, so that nothing else runs.
        with one_thread():
            times = time_calls(trained.predict, blocks.X[:, None], settings.calls)
        vectors = trained.notes.get("support_vectors")
        timed.setdefault(model, {})[task] = replace(times, support_vectors=vectors)
    times_by_model = {
        model: InferenceTimes(**asdict(regression), classification=by_task.get(Task.CLASSIFICATION))
        if (regression := by_task.get(Task.REGRESSION))
        else InferenceTimes(**asdict(by_task[Task.CLASSIFICATION]))
        for model, by_task in timed.items()
    }
    running = _time_first_estimate(subject, settings)
    return PartResult([INFERENCE(times_by_model), ANYTIME_TIME(running)])


def _time_first_estimate(subject: Subject, settings: StudySettings) -> InferenceTime | None:
    """Return the computing time of the network's first estimate, or None if it cannot predict."""
    model = pretrained()
    if not subject.detections or not is_same_rate(subject.dataset.layout.rate, model.rate):
        return None
    labelled = LabelledTouches.cut(subject.dataset, subject.starts)
    home = conditioning_contacts(labelled, subject)
    if home is None:
        return None
    adapted = subject.adapted or conditioned_model(RIG_ESTIMATOR.name, home, settings.seed)
    first = Touches.all_lengths(model.rate)[0]
    inputs = [home.touches.take(np.array([k])).until(first) for k in range(min(len(home), ASKED))]
    with one_thread():
        return time_calls(adapted.model.predict_touches, inputs, settings.calls)


def _train_briefly(job: tuple[str, Task], blocks: LabelledWindows, seed: int) -> WindowModel:
    """Return a model that was trained briefly, for timing only.

    Slow estimators get fewer pinches.
    """
    model, task = job
    entry = ESTIMATORS.find(model)
    options = dict(entry.quick)
    if entry.slow:  # its inference time does not depend on the training data
        blocks = blocks.take(np.arange(0, len(blocks), max(1, len(blocks) // SLOW_WINDOWS)))
    return fit_model(blocks, model, task, seed, options)


INFERENCE = Field.optional("inference_us", dict[str, InferenceTimes])
ANYTIME_TIME = Field.optional("anytime_us", InferenceTime)
#: Time of one window on a computer that the paper does not name (section IV).
PUBLISHED = {"svm": "< 1 ms", "cnn": "1.4 ms"}

_P99 = Row[InferenceTime]("p99", lambda t: t.p99, "us")
_MEDIAN = Row[InferenceTime]("median", lambda t: t.p50, "us")
_TIMES = (
    _MEDIAN,
    _P99,
    Row[InferenceTime]("p99 with preempted calls", lambda t: t.p99_with_preempted, "us"),
)


def inference_table(results: SubjectResults) -> Table | None:
    times = results[INFERENCE]
    if not times:
        return None
    entries: list[tuple[Cell, InferenceTime | None, bool]] = []
    for name, timed in times.items():
        title = names.estimator(name).title
        entries.append((Cell(title, _remarks(timed)), timed, False))
        classifier = timed.classification
        if classifier:
            entries.append(
                (Cell(f"{title}, classification", _remarks(classifier)), classifier, False)
            )
    network = f"{names.estimator(RIG_ESTIMATOR.name).title}, first estimate"
    entries.append((Cell(network), results[ANYTIME_TIME], False))
    times_shown = [time for _, time, _ in entries if time]
    busiest = max(times_shown, key=lambda time: time.load)
    fewest = min(time.calls for time in times_shown)
    caption = (
        f"One window at a time, one thread, this machine; {counted(fewest, 'call')} or more each. "
        "Calls that another process interrupted are not included, except where stated. The paper "
        "does not name its computer, so its times are not comparable. "
        f"Load of the machine: {busiest.load:.1f} on {busiest.cores} cores."
    )
    return matrix(caption, (_MEDIAN, _P99), entries)


def _remarks(time: InferenceTime) -> str:
    vectors = "" if time.support_vectors is None else f"{time.support_vectors:,} support vectors"
    preempted = f"{counted(time.preempted, 'call')} preempted" if time.preempted else ""
    return "; ".join(filter(None, (vectors, preempted)))


def _find_times(name: str) -> Callable[[SubjectResults], InferenceTimes | None]:
    return lambda results: (results[INFERENCE] or {}).get(name)


def _find_classifier(name: str) -> Callable[[SubjectResults], InferenceTime | None]:
    find = _find_times(name)
    return lambda results: times.classification if (times := find(results)) else None


def _rows(subjects: Subjects) -> list[Row[SubjectResults]]:
    def load(results: SubjectResults) -> Value:
        times = next(iter((results[INFERENCE] or {}).values()), None)
        return None if times is None else times.load

    rows = [Row("Load of the machine meanwhile", load, "rate")]
    scored = distinct(name for r in subjects.values() for name in r[INFERENCE] or {})
    for name in names.estimators(distinct([*ESTIMATORS.names, *scored]), True):
        title = names.estimator(name).title
        rows += [
            row_for_results(
                row,
                f"{title}, one window: ",
                _find_times(name),
                PUBLISHED.get(name, ABSENT) if row is _P99 else ABSENT,
            )
            for row in _TIMES
        ]
        rows.append(
            row_for_results(_P99, f"{title} classifier, one window: ", _find_classifier(name))
        )
    return rows


PART = Part(
    "time",
    "Time of one estimate",
    [Step("inference time", inference, late=True, cost=10)],
    tables=[inference_table],
    rows=_rows,
    columns=("median",),
)
