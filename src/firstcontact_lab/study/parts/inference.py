"""How long one window takes, as in use: one at a time, one thread."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from msgspec.structs import asdict

from firstcontact.core import is_same_rate, one_thread
from firstcontact.models import (
    DURATION,
    Fit,
    InferenceTime,
    LabelledTouches,
    Task,
    fit_model,
    make_estimator,
    moments,
    pretrained,
    time_calls,
    time_inference,
    window_estimators,
)
from firstcontact_lab.report.findings import PartResult
from firstcontact_lab.report.results.board import read_board
from firstcontact_lab.report.results.stiffness import InferenceTimes
from firstcontact_lab.report.results.study import SubjectResults
from firstcontact_lab.study._subject import Subject
from firstcontact_lab.study.parts.anytime import conditioned_on, home_of
from firstcontact_lab.study.settings import StudySettings

#: Contacts that the any-time network is asked about in turn.
ASKED = 100


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
    for model, entry in window_estimators().items():
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
    board = read_board(Path(settings.board)) if settings.board else None
    running = _anytime(subject, settings)
    return PartResult(SubjectResults(inference_us=found, anytime_us=running, board=board))


def _anytime(subject: Subject, settings: StudySettings) -> InferenceTime | None:
    """The any-time network's first answer to a contact; None where it cannot be asked."""
    model = pretrained()
    if not subject.found or not is_same_rate(subject.dataset.layout.rate, model.rate):
        return None
    known = LabelledTouches.of(subject.dataset, subject.starts)
    home = home_of(known, subject)
    if home is None:
        return None
    its = conditioned_on(model, home, settings.seed).model
    # As live asks: how fast the hand closes is worked out once a contact, before any answer.
    first = moments(model.rate)[0]
    asked = [home.touches.take(np.array([k])).until(first) for k in range(min(len(home), ASKED))]
    inputs = [(touch, its.rig_features(touch)) for touch in asked]
    with one_thread():
        return time_calls(lambda pair: its.answers(*pair), inputs, settings.calls)


def measure(fit: Fit, calls: int) -> InferenceTime:
    """Train, then time the model and its reference on the same windows."""
    model, learn = fit_model(fit), fit.learn
    estimator = make_estimator(fit.model, fit.task, learn.rate)
    return time_inference(model, learn.X, estimator.reference(model, learn.X, learn.y), calls)
