"""How long one window takes, as in use: one at a time, one thread."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from firstcontact.stiffness.estimator import Task
from firstcontact.stiffness.timing import time_inference
from firstcontact.study.jobs import Runner
from firstcontact.study.settings import DURATION, Settings
from firstcontact.study.subject import Outcome, Subject
from firstcontact.study.training import Fit, train

#: Epochs of the network that is timed: its arithmetic does not depend on them.
TIMED_EPOCHS = 1


@dataclass(frozen=True, slots=True, eq=False)
class Timing:
    """One model to train and time: what it learns, and how many calls."""

    fit: Fit
    calls: int


def inference(subject: Subject, settings: Settings, runner: Runner) -> Outcome:
    """p50 and p99 of single-window regression, beside the training library's own predict.

    Models learn from all blocks, as they would for use.
    """
    if len(subject.levels) < 2:
        return Outcome(left_out=["Inference time: no Shore A regression model can be trained."])
    data = subject.windows(DURATION)
    blocks = data.take(~data.test)
    tree: dict[str, Any] = {}
    for model in ("svm", "cnn"):
        fit = Fit(model, Task.REGRESSION, blocks, blocks.X, settings.seed, TIMED_EPOCHS)
        # One job at a time: what is timed has the machine to itself.
        tree[model] = runner.map(measure, [Timing(fit, settings.calls)])[0]
    return Outcome({"inference_us": tree})


def measure(job: Timing) -> dict[str, Any]:
    """Train, then time the model and its reference on the same windows.

    Returns
    -------
    dict
        As :func:`firstcontact.stiffness.timing.time_inference`.
    """
    model = train(job.fit)
    return time_inference(model, job.fit.learn.X, job.fit.learn.y, job.calls)
