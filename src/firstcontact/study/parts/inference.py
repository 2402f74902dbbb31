"""How long one window takes, as in use: one at a time, one thread."""

from __future__ import annotations

import numpy as np
from msgspec.structs import asdict

from firstcontact.core.jobs import one_thread
from firstcontact.learning.training import DURATION, Fit, train
from firstcontact.report.findings import PartResult
from firstcontact.report.results.stiffness import InferenceTimes
from firstcontact.report.results.study import SubjectResults
from firstcontact.stiffness import ESTIMATORS, Task, make_estimator
from firstcontact.stiffness.timing import InferenceTime, time_inference
from firstcontact.study._subject import Subject
from firstcontact.study.settings import StudySettings


def inference(subject: Subject, settings: StudySettings) -> PartResult:
    """p50 and p99 of single-window inference, beside the training library's own predict.

    Models learn from all blocks, as they would for use: a support vector
    machine takes the longer the more support vectors its data asked for.
    """
    data = subject.windows(DURATION)
    blocks = data.take(~data.test)
    if len(np.unique(blocks.y)) < 2:
        return PartResult(
            left_out=[
                "Inference time: windows of two Shore A levels or more are needed to train a model."
            ]
        )
    found: dict[str, InferenceTimes] = {}
    for model, entry in ESTIMATORS.items():
        if entry.baseline:
            continue
        times: dict[Task, InferenceTime] = {}
        for task in entry.tasks:
            # A slow one's arithmetic differs by a few outputs only: once is enough.
            if times and entry.slow:
                continue
            fit = Fit(model, task, blocks, blocks.X, settings.seed, entry.quick)
            # Here and nowhere else: the results say which machine, and it is to have nothing else
            # to do.
            with one_thread():
                times[task] = measure(fit, settings.calls)
        classification = times.get(Task.CLASSIFICATION)
        if regression := times.get(Task.REGRESSION):
            found[model] = InferenceTimes(**asdict(regression), classification=classification)
        elif classification:
            found[model] = InferenceTimes(**asdict(classification))
    return PartResult(SubjectResults(inference_us=found))


def measure(fit: Fit, calls: int) -> InferenceTime:
    """Train, then time the model and its reference on the same windows."""
    model, learn = train(fit), fit.learn
    estimator = make_estimator(fit.model, fit.task, learn.rate)
    return time_inference(model, learn.X, estimator.reference(model, learn.X, learn.y), calls)
