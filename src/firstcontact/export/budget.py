"""Reduction of support vector machines, so that a microcontroller computes them fast enough."""

from __future__ import annotations

import logging
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from firstcontact.contact.contacts import first_contact
from firstcontact.core import Contact, Dataset, ModelError
from firstcontact.models import Model, Windows
from firstcontact.models.windows.svm import SvmModel
from firstcontact.models.windows.window_predictor import WindowPredictor
from firstcontact.signal import contact_windows, samples_in
from firstcontact.signal.windowing import BASELINE

_log = logging.getLogger("firstcontact.export")
#: Clock of a Teensy 4, Hz, and assumed cycles per instruction.
CLOCK, CYCLES = 600e6, 1.5
#: Smallest number of windows to fit a smaller model to.
FEWEST_WINDOWS = 10


def microseconds(count: float) -> float:
    """Return the time for ``count`` instructions on a Cortex-M7 at 600 MHz, us."""
    return 1e6 * CYCLES * count / CLOCK


def require_svm(window: WindowPredictor) -> SvmModel:
    """Return the SVM of a window predictor. Raise ModelError if it has another model."""
    if not isinstance(window.model, SvmModel):
        raise ModelError(f"{window.name} cannot be made smaller: train the estimator svm instead")
    return window.model


def instructions(model: SvmModel) -> int:
    """Return an upper bound on the number of instructions for a prediction on a Cortex-M7."""
    vectors, inputs = model.to_arrays()["vectors"].shape
    decisions, classes = len(model.to_arrays()["bias"]), len(model.spec.classes)
    samples = inputs - 1
    count = (
        _matrix_instructions(vectors, samples + 1) + 40 * vectors + 5 * samples + 45
    )  # the kernel
    count += (
        _matrix_instructions(decisions, vectors) + 14 * decisions + 25 * decisions * bool(classes)
    )
    count += 72 * (samples + samples_in(BASELINE, model.spec.rate))  # the window and its baseline
    return int(1.02 * (count + 26 * samples + 10 * classes + 450))


def _matrix_instructions(n: int, inputs: int) -> int:
    """Return the number of instructions to multiply a matrix, shape (n, inputs), by a vector."""
    rows, each, overhead = (8, 20, 54) if n >= 8 else (1, 5, 30)
    return -(-n // rows) * (each * inputs + overhead) + 35


def small_enough(model: Model, dataset: Dataset | None, budget_us: float) -> Model:
    """Return a copy of the model in which each window model predicts within ``budget_us`` us.

    Smaller SVMs are fitted to the pinches of ``dataset``. Raise ModelError if none is fast enough,
    or if a window model is no SVM.
    """
    contacts = [] if dataset is None else _contacts(dataset, model)
    predictors = tuple(
        _fitting(p, dataset, contacts, budget_us) if isinstance(p, WindowPredictor) else p
        for p in model.predictors
    )
    return replace(model, predictors=predictors)


def forms(window: WindowPredictor, X: Windows, sessions: NDArray[np.str_]) -> list[WindowPredictor]:
    """Return an SVM and smaller approximations of it, the smallest first.

    They are fitted to most of the windows ``X``. Their intervals are wider by their errors on the
    others. ``sessions`` holds the session of each window.
    """
    model = require_svm(window)
    is_held_out = np.isin(sessions, np.unique(sessions)[::5])
    if is_held_out.all():
        is_held_out = np.arange(len(X)) % 5 == 0
    candidates = []
    for form in model.smaller(X[~is_held_out]):
        interval = window.interval
        if interval is not None:
            away = np.abs(form.predict(X[is_held_out]) - model.predict(X[is_held_out]))
            further = float(np.quantile(away, interval.level))
            wider = tuple(half + further for half in interval.half_widths)
            interval = replace(interval, half_widths=wider)
        candidates.append(WindowPredictor(form, interval, window.record, window.quantity))
    return [*candidates, window]


def _contacts(dataset: Dataset, model: Model) -> list[Contact | None]:
    if any(p.first is not None for p in dataset.pinches) or model.detector is None:
        return [p.first for p in dataset.pinches]
    return [first_contact(model.detector, pinch) for pinch in dataset.pinches]


def _fitting(
    window: WindowPredictor,
    dataset: Dataset | None,
    contacts: list[Contact | None],
    budget_us: float,
) -> WindowPredictor:
    candidates = [window]
    if dataset is not None:
        window.model.spec.require_rate(dataset.layout.rate)
        X, has_window = contact_windows(dataset, contacts, window.model.spec.duration)
        if len(X) < FEWEST_WINDOWS:
            raise ModelError(
                f"the data hold only {len(X)} contacts, but {FEWEST_WINDOWS} are needed to fit a "
                "smaller model: give the recordings that the model was trained on"
            )
        candidates = forms(window, X, dataset.sessions[has_window])
    times = [microseconds(instructions(require_svm(form))) for form in candidates]
    quick = [form for form, time in zip(candidates, times, strict=True) if time <= budget_us]
    if not quick:
        raise ModelError(
            f"the smallest form of {window.name} takes about {times[0]:.0f} us, more than "
            f"--budget-us {budget_us:g}: raise it"
            + ("" if dataset is not None else ", or give its training recordings with --data")
        )
    chosen = quick[-1]
    _log.info(
        "%s: %d support vectors, about %.0f us", chosen.name,
        chosen.model.notes["support_vectors"], times[len(quick) - 1],
    )  # fmt: skip
    return chosen
