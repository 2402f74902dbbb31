"""The SVM of the chain cuts its window as training does, and predicts what the model predicts."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from firstcontact.chain.image import DetectorKind
from firstcontact.core.quantity import SHORE_A, STIFFNESS, Quantity
from firstcontact.models import Spec, Task
from firstcontact.models.anytime import Hints
from firstcontact.models.interval import Interval
from firstcontact.models.windows.svm import SvmModel
from firstcontact.models.windows.window_predictor import WindowPredictor
from firstcontact.signal import SavitzkyGolay
from firstcontact.signal.windowing import cut_window
from firstcontact.testing.synthetic import RATE
from random_chains import python_events, random_image, random_stream

SAMPLES = 74


def predictor(classes: tuple[float, ...] = (), quantity: Quantity = SHORE_A) -> WindowPredictor:
    rng = np.random.default_rng(0)
    task = Task.CLASSIFICATION if classes else Task.REGRESSION
    rows, one = len(classes) * (len(classes) - 1) // 2 or 1, np.array([0.0, 1.0])
    vectors = rng.standard_normal((40, SAMPLES + 1))
    weights, bias = rng.standard_normal((rows, 40)), rng.standard_normal(rows)
    parameters = np.array([1.0, 0.3 / SAMPLES, 0.1])
    target = np.array([45.0, 20.0])
    model = SvmModel(
        Spec(task, RATE, SAMPLES, 1, classes), one, vectors, weights, bias, target, parameters
    )
    interval = Interval(0.9, (40.0, 50.0), (1.0, 2.5, 60.0))
    if quantity.is_logarithmic:
        model.target, interval = (2.0, 0.8), Interval(0.9, (1.5,), (0.1, 0.4), quantity.limits)
    return WindowPredictor(model, interval, quantity=quantity)


@pytest.mark.parametrize(
    ("classes", "quantity"),
    [((), SHORE_A), ((10.0, 29.0, 43.0), SHORE_A), ((), STIFFNESS), ((5.0, 45.0), STIFFNESS)],
    ids=["svr", "svc", "svr of a logarithm", "svc of N/mm"],
)
@given(
    seed=st.integers(0, 1000),
    lead=st.integers(0, 150),
    fault=st.sampled_from([None, np.nan, np.inf, 1e300]),
)
def test_a_signal_gives_the_prediction_of_its_window(
    classes: tuple[float, ...], quantity: Quantity, seed: int, lead: int, fault: float | None
) -> None:
    asked = predictor(classes, quantity)
    rng = np.random.default_rng(seed)
    signal = 10 ** rng.uniform(-6, 2) * rng.normal(rng.normal(), 1.0, lead + SAMPLES + 2)
    if fault is not None:
        signal[rng.integers(len(signal))] = fault
    made = asked.predict(signal, SAMPLES, 0, Hints())
    with np.errstate(invalid="ignore", over="ignore"):
        window = cut_window(SavitzkyGolay().update(signal[:, None])[:, 0], lead, SAMPLES, RATE)
    if window is None or not np.isfinite(window).all():
        assert made is None
        return
    value, _, low, high = (float(a[0]) for a in asked.predict_windows(window[None]))
    np.testing.assert_allclose(made[:3], (value, low, high), rtol=1e-4)


@pytest.mark.parametrize("kind", ["svr", "svc"])
def test_signals_without_quiet_or_swing_have_no_prediction(kind: str) -> None:
    asked = predictor(() if kind == "svr" else (10.0, 29.0))
    assert asked.predict(np.ones(200), SAMPLES, 0, Hints()) is None
    assert asked.predict(np.arange(SAMPLES + 2.0), SAMPLES, 0, Hints()) is None


def test_a_chain_emits_what_each_window_gives() -> None:
    """Estimates come with the samples of their moments: window and look-ahead of the filter."""
    image = random_image(0, DetectorKind.THRESHOLD, "svr")
    rng = np.random.default_rng(0)
    events = [e for _ in range(60) for e in python_events(image, random_stream(rng))]
    made = [e for e in events if e.samples > 0]
    assert {e.samples for e in made} == {25, 74}
    for e in made:
        assert e.known >= e.sample + e.samples + 1
        assert (e.samples == 74) == (e.low == e.value == e.high)
