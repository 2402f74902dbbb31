"""How long one window takes, beside the library that trained the model."""

from __future__ import annotations

import resource
import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import InputError
from firstcontact.stiffness.cnn import as_input
from firstcontact.stiffness.cnn_model import CnnModel, compress
from firstcontact.stiffness.estimator import Model, Values, Windows
from firstcontact.stiffness.svm import machine_of
from firstcontact.stiffness.svm_model import SvmModel, shape_and_level

#: Calls before the clock counts: caches and parts that are built late.
WARM_UP = 200
#: The reference is slow; a tenth of the calls gives its percentiles well enough.
REFERENCE_SHARE = 10

Call = Callable[[Any], object]


def microseconds(
    call: Call, windows: Sequence[Any] | NDArray[Any], calls: int
) -> NDArray[np.float64]:
    """Time of each of ``calls`` single calls over the windows in turn, µs, shape (calls,)."""
    for i in range(min(WARM_UP, calls)):
        call(windows[i % len(windows)])
    spent = np.empty(calls)
    for i in range(calls):
        window = windows[i % len(windows)]
        began = time.perf_counter_ns()
        call(window)
        spent[i] = time.perf_counter_ns() - began
    return spent / 1e3


def preemptions() -> int:
    """How often other processes have taken the core away from this one."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_nivcsw


def reference(model: Model, X: Windows, y: Values) -> tuple[str, Call, Sequence[Any]]:
    """The training library's own answer to one window, its inputs ready made.

    Parameters
    ----------
    model
        An SVM or CNN.
    X, y
        What it was trained on: scikit-learn's machine is fitted again with the
        same parameters. PyTorch's network has fresh weights, which change no time.

    Returns
    -------
    name, call, inputs
        ``call(inputs[i])`` does the work.

    Raises
    ------
    InputError
        For a model that no library trained.
    """
    if isinstance(model, SvmModel):
        arrays = model.to_arrays()
        mean, deviation = arrays["target"]
        inputs = shape_and_level(X, arrays["level"])
        c, gamma, epsilon = (float(p) for p in arrays["parameters"])
        machine = machine_of(model.spec.task, (c, gamma, epsilon))
        machine.fit(inputs, (y - mean) / deviation)
        return "scikit-learn predict", machine.predict, list(inputs[:, None, :])
    if isinstance(model, CnnModel):
        import torch

        from firstcontact.stiffness.efficientnet import EfficientNet

        network = EfficientNet(model.spec.channels, len(model.spec.classes) or 1).eval()
        network.to(memory_format=torch.channels_last)  # type: ignore[call-overload]

        def predict(window: torch.Tensor) -> object:
            with torch.inference_mode():
                return network(window)

        compressed = compress(X, model.to_arrays()["scale"])
        return "eager PyTorch", predict, [as_input(window[None]) for window in compressed]
    raise InputError(f"a {model.kind} model has no training library to be timed against")


def time_inference(model: Model, X: Windows, y: Values, calls: int = 10_000) -> dict[str, Any]:
    """Single-window inference on one thread, beside the training library in the same run.

    Parameters
    ----------
    model
        An SVM or CNN, trained on ``X`` and ``y``.
    X, y
        Its training windows (n, samples, channels) and targets (n,).
    calls
        Single calls to time.

    Returns
    -------
    dict
        ``p50`` and ``p99``, µs; ``calls``; ``preempted``, how often the core was
        taken away meanwhile, which makes a p99 another process's; the same of
        the ``reference``; ``speedup``, the ratio of the medians.
    """
    import threadpoolctl

    name, call, inputs = reference(model, X, y)
    with threadpoolctl.threadpool_limits(1):
        before = preemptions()
        own = microseconds(model.predict_one, X, calls)
        preempted = preemptions() - before
        theirs = microseconds(call, inputs, max(1, calls // REFERENCE_SHARE))
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
