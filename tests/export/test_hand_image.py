"""The image for a hand, smaller models for it, and the costs that the docs state."""

import json
from dataclasses import replace
from pathlib import Path

import measure
import numpy as np
import pytest
from test_model_parity import INTERVAL, learned

from firstcontact.chain import Chain, EventKind, Image, build_image
from firstcontact.core import Block, Calibration, InputError, VibrationCalibration, fingertip_layout
from firstcontact.export.budget import forms, small_enough
from firstcontact.export.hand_image import hand_image
from firstcontact.models import ESTIMATORS, Model, Task, load_model, make_estimator
from firstcontact.models.model import shipped_model
from firstcontact.models.windows.window_predictor import WindowPredictor
from firstcontact.streaming.twin import twin_model
from firstcontact.testing import closings
from firstcontact.testing.synthetic import RATE, toy_windows
from firstcontact.twin import TwinStream
from firstcontact.twin.sensor import DeviceFilter


def test_default_model_with_a_rig_of_each_finger_fits_and_gives_the_events_of_the_computer() -> (
    None
):
    folder = twin_model("paper-rig", 0)
    model = load_model(folder)
    assert model.network is not None
    network = model.network
    assert (network.name, set(network.regressions)) == ("combined", {-1, 0, 1})
    data = hand_image(folder).data
    assert len(data) < 256 * 1024
    whole = build_image(
        network.rate, model.own_detector.chain_constants(network.rate), network.chain_constants()
    )
    layout = fingertip_layout()
    floors = [VibrationCalibration(finger, 0.0018) for finger in layout.vibration_fingers]
    samples = Block(DeviceFilter().update(TwinStream(seed=2).read(8 * 4936)))
    ours, theirs = (
        [tuple(event) for event in Chain(image, layout, Calibration(tuple(floors))).take(samples)]
        for image in (whole, Image(data))
    )
    assert ours == theirs
    assert sum(event[0] == EventKind.ESTIMATED for event in ours) > 20


@pytest.mark.usefixtures("small_searches")
def test_a_hand_gets_the_estimator_that_predicts_by_default_or_the_chosen_one(
    tmp_path: Path,
) -> None:
    adapted = load_model(twin_model("paper-rig", 0))
    svm, peak = (learned(name, Task.REGRESSION) for name in ("svm", "peak"))
    both = replace(adapted, predictors=(svm, peak, *adapted.predictors))
    both.write(tmp_path)
    network = hand_image(twin_model("paper-rig", 0)).digest
    assert hand_image(tmp_path, estimator="combined").digest == network
    chosen = hand_image(tmp_path)
    assert chosen.digest == hand_image(tmp_path, estimator="svm").digest != network
    assert b'"anytime":"svm"' in chosen.data
    with pytest.raises(InputError, match="peak predicts in Python"):
        hand_image(tmp_path, estimator="peak")


def test_a_smaller_form_has_a_wider_interval() -> None:
    X, y, sessions = toy_windows()
    # What cannot be learned takes many vectors.
    noisy = y + np.random.default_rng(0).normal(0, 6, len(y))
    estimator = make_estimator(
        ESTIMATORS.default, Task.REGRESSION, RATE, **ESTIMATORS[ESTIMATORS.default].quick
    )
    named = WindowPredictor(estimator.fit(X, noisy, sessions, seed=1), INTERVAL)
    *smaller, complete = forms(named, X, sessions.astype(str))
    assert complete is named
    assert smaller
    new = toy_windows(60, seed=5)[0]
    for form in smaller:
        grown = np.subtract(form.interval.half_widths, named.interval.half_widths)
        assert (grown >= 0).all()
        np.testing.assert_allclose(grown, grown[0])
        away = np.abs(form.model.predict(new) - named.model.predict(new))
        assert (away <= 3 * grown[0] + 1e-6).mean() > 0.8


def test_without_an_interval_there_is_nothing_to_widen() -> None:
    named = learned(ESTIMATORS.default, Task.CLASSIFICATION)
    X, _, sessions = toy_windows()
    assert all(form.interval is None for form in forms(named, X, sessions.astype(str)))


def test_window_models_are_held_to_the_budget() -> None:
    model = Model(None, (learned(ESTIMATORS.default, Task.REGRESSION),))
    with pytest.raises(InputError, match="--budget-us"):
        small_enough(model, None, 1.0)


def test_a_network_is_left_as_it_is() -> None:
    model = shipped_model()
    assert small_enough(model, closings(8), 30.0).predictors == model.predictors


DOCS = Path(__file__).parents[2] / "docs"
RESULTS = json.loads((DOCS / "results" / "embedded.json").read_text(encoding="utf-8"))


def test_the_pages_have_the_tables_of_the_results() -> None:
    for page in measure.PAGES:
        text = page.read_text(encoding="utf-8")
        assert measure.fill(text, "embedded", measure.tables(RESULTS)) == text


def test_the_page_says_what_the_chain_takes() -> None:
    page = (DOCS / "reference" / "embedded.md").read_text(encoding="utf-8")
    for name in ("chain_sample", "chain_costliest", "chain_first", "chain_25", "chain_74"):
        assert f"{RESULTS['models'][name]['instructions']:,}" in page


def test_most_estimates_are_in_time_on_the_hand() -> None:
    for row in RESULTS["in_time"].values():
        assert row["closings"] >= 1000
        assert row["any"] >= 0.99 * row["instant"]


def test_c_equals_python_at_every_query() -> None:
    requests = [row for row in RESULTS["models"].values() if "asked" in row]
    assert sum(row["asked"] >= 1000 for row in requests) > 3
    for row in requests:
        assert row["class_mismatches"] == 0
        assert row["max_abs_error"] <= 0.01
        assert row["same_bytes"]


def test_the_budgets_of_the_hand_are_preserved() -> None:
    """The docs state the costs of the default export."""
    models = RESULTS["models"]
    assert all(models[name]["instructions"] <= 120_000 for name in models if name[:3] == "svr")
    assert models["chain_costliest"]["instructions"] <= 200_000  # 0.5 ms
    assert models["chain_74"]["flash"] <= 300_000  # program and image
    assert models["chain_74"]["ram"] <= 64_000
