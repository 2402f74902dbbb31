"""Check of an any-time estimator, such as that of a plug-in."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

from firstcontact.contact.detector_file import pretrained_detector
from firstcontact.core import Block, Dataset, Estimate, Label, Pinch
from firstcontact.models import (
    ESTIMATORS,
    AnytimeEstimator,
    AnytimeModel,
    Model,
    Task,
    Touches,
    load_model,
)
from firstcontact.streaming import Pipeline
from firstcontact.testing.synthetic import RATE
from firstcontact.twin import BLOCKS, CONDITIONS, draw_pinch, simulate_pinch
from firstcontact.twin.draw import draw_specimen


def check_anytime(estimator_class: type[AnytimeEstimator]) -> None:
    """Assert that an any-time estimator behaves as its base class requires, on simulated contacts.

    Predictions must be the same in recordings and live, before and after saving.

    Parameters
    ----------
    estimator_class
        Class of the estimator. Saving and loading are checked only if the class is registered.

    Raises
    ------
    AssertionError
        A check failed; the message names it.
    """
    assert estimator_class.title, "the estimator has no title"
    data = _pinches(60)
    touches, rows = Touches.cut(data, [pinch.first for pinch in data.pinches])
    shore_a, sessions = data.shore_a[rows], data.sessions[rows]

    def fitted() -> AnytimeModel:
        return estimator_class(Task.REGRESSION, RATE).fit(touches, shore_a, sessions, 3)[0]

    model, again = fitted(), fitted().to_arrays()
    assert isinstance(model, estimator_class.model), f"it makes a {type(model).__name__}"
    assert model.name == estimator_class.name, "the model has another name than the estimator"
    for name, array in model.to_arrays().items():
        assert np.array_equal(array, again[name]), f"same seed, another model: array {name}"
    lengths = list(model.lengths)
    assert lengths == sorted(set(lengths)), "the lengths do not ascend"
    assert lengths[0] > 0, "a length is not above 0"
    estimates = [event for pinch in data.pinches[:6] for event in _live_estimates(model, pinch)]
    assert estimates, "no contact is predicted"
    _check_offline(model, estimates)
    if ESTIMATORS.get(estimator_class.name) is estimator_class:
        with tempfile.TemporaryDirectory() as folder:
            saved = Model(pretrained_detector(), (model,)).save(Path(folder) / "mödel")
            loaded = load_model(saved).anytime
        assert isinstance(loaded, estimator_class.model), "another class of model is loaded"
        _check_offline(loaded, estimates)


def _pinches(n: int) -> Dataset:
    """Return ``n`` simulated pinches of five blocks in turn, spread over four sessions."""
    rig, pinches = CONDITIONS["paper-rig"], []
    for k in range(n):
        kind, session = BLOCKS[k % len(BLOCKS)], f"s{k % 4}"
        specimen = draw_specimen(0, rig, kind, 0)
        label = Label(kind.name, kind.shore_a, session=session, specimen=kind.name)
        pinches.append(simulate_pinch(draw_pinch(0, rig, session, specimen, k), label, 10_000 * k))
    return Dataset(tuple(pinches), "twin")


def _live_estimates(model: AnytimeModel, pinch: Pinch) -> list[tuple[Pinch, Estimate]]:
    """Run a live session of one closing. Return its estimates, each as a pair with the pinch."""
    pipeline = Pipeline(pinch.layout, pretrained_detector(), model, real_time=False)
    events = [*pipeline.update(Block(pinch.data, pinch.first_sample), 0.0), *pipeline.finish()]
    return [(pinch, event) for event in events if isinstance(event, Estimate)]


def _check_offline(model: AnytimeModel, estimates: list[tuple[Pinch, Estimate]]) -> None:
    for pinch, estimate in estimates:
        at = estimate.elapsed + 0.5 / model.rate
        made = model.predict_pinches(Dataset((pinch,)), [estimate.contact], at)
        if made.elapsed[0] == estimate.elapsed:  # else the second finger touched before
            expected = estimate.value, estimate.low, estimate.high
            assert (made.value[0], made.low[0], made.high[0]) == expected, (
                "a recording and a live session give different predictions"
            )
