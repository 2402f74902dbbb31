"""How long one window takes, as in use: one at a time, one thread."""

from __future__ import annotations

from typing import Any

import numpy as np

from firstcontact.core.jobs import one_thread
from firstcontact.learning.training import DURATION, Fit, train
from firstcontact.report.findings import PartResult
from firstcontact.stiffness import ESTIMATORS, Task, make_estimator
from firstcontact.stiffness.timing import time_inference
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
    tree: dict[str, Any] = {}
    for model, entry in ESTIMATORS.items():
        if entry.baseline:
            continue
        for task in entry.tasks:
            # A slow one's arithmetic differs by a few outputs only: once is enough.
            if tree.get(model) and entry.slow:
                continue
            fit = Fit(model, task, blocks, blocks.X, settings.seed, entry.quick)
            # Here and nowhere else: the results say which machine, and it is to have nothing else
            # to do.
            with one_thread():
                found = measure(fit, settings.calls)
            if task is Task.REGRESSION:
                tree[model] = found
            else:
                tree.setdefault(model, {})[task.value] = found
    return PartResult({"inference_us": tree})


def measure(fit: Fit, calls: int) -> dict[str, Any]:
    """Train, then time the model and its reference on the same windows.

    Returns
    -------
    dict
        As :func:`firstcontact.stiffness.timing.time_inference`, and
        ``support_vectors`` where the model has some.
    """
    model, learn = train(fit), fit.learn
    estimator = make_estimator(fit.model, fit.task, learn.rate)
    found = time_inference(model, learn.X, estimator.reference(model, learn.X, learn.y), calls)
    counts = {k: v for k, v in model.notes.items() if k == "support_vectors"}
    return {**found, **counts}
