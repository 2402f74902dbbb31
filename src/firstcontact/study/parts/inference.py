"""How long one window takes, as in use: one at a time, one thread."""

from __future__ import annotations

import resource
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.stiffness.estimator import Model, Task
from firstcontact.study.jobs import Runner
from firstcontact.study.settings import DURATION, Settings
from firstcontact.study.subject import Outcome, Subject
from firstcontact.study.training import Examples, Fit, train

#: Calls before the clock counts: caches and lazily built parts.
WARM_UP = 200
#: The reference is slow: a tenth of the calls gives its median well enough.
REFERENCE_SHARE = 10
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
        ``p50`` and ``p99`` of single calls, µs; ``calls``; ``preempted``, how often the core was
        taken away meanwhile; the same of the ``reference``; ``speedup``, the ratio of the medians.
    """
    model = train(job.fit)
    windows = job.fit.learn.X
    before = _preemptions()
    own = _microseconds(model.predict_one, windows, job.calls)
    preempted = _preemptions() - before
    name, reference, inputs = _REFERENCES[job.fit.model](job.fit.learn, model)
    theirs = _microseconds(reference, inputs, max(1, job.calls // REFERENCE_SHARE))
    return {
        "p50": float(np.percentile(own, 50)),
        "p99": float(np.percentile(own, 99)),
        "calls": len(own),
        "preempted": preempted,
        "reference": name,
        "reference_p50": float(np.percentile(theirs, 50)),
        "reference_p99": float(np.percentile(theirs, 99)),
        "reference_calls": len(theirs),
        "speedup": float(np.percentile(theirs, 50) / np.percentile(own, 50)),
    }


def _preemptions() -> int:
    """How often other processes took the core away, which makes a p99 theirs."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_nivcsw


def _microseconds(
    call: Callable[[Any], object], windows: Sequence[Any] | NDArray[Any], calls: int
) -> NDArray[np.float64]:
    """Time of each call, µs, shape (calls,)."""
    for i in range(min(WARM_UP, calls)):
        call(windows[i % len(windows)])
    spent = np.empty(calls)
    for i in range(calls):
        window = windows[i % len(windows)]
        began = time.perf_counter_ns()
        call(window)
        spent[i] = time.perf_counter_ns() - began
    return spent / 1e3


Reference = tuple[str, Callable[[Any], object], Sequence[Any]]


def _scikit_learn(learn: Examples, model: Model) -> Reference:
    from firstcontact.stiffness.svm import machine_of
    from firstcontact.stiffness.svm_model import shape_and_level

    arrays = model.to_arrays()
    mean, sd = arrays["target"]
    inputs = shape_and_level(learn.X, arrays["level"])
    c, gamma, epsilon = (float(p) for p in arrays["parameters"])
    machine = machine_of(Task.REGRESSION, (c, gamma, epsilon)).fit(inputs, (learn.y - mean) / sd)
    return "scikit-learn predict", machine.predict, list(inputs[:, None, :])


def _eager_torch(learn: Examples, model: Model) -> Reference:
    import torch

    from firstcontact.stiffness.cnn import as_input
    from firstcontact.stiffness.efficientnet import EfficientNet

    # Weights do not matter for the time, so the reference stays untrained.
    network = EfficientNet(learn.X.shape[2], 1).eval()
    network.to(memory_format=torch.channels_last)  # type: ignore[call-overload]

    def predict(window: NDArray[Any]) -> object:
        with torch.inference_mode():
            return network(window)

    return "eager PyTorch", predict, [as_input(window[None]) for window in learn.X]


_REFERENCES: dict[str, Callable[[Examples, Model], Reference]] = {
    "svm": _scikit_learn,
    "cnn": _eager_torch,
}
