"""Estimates from both fingers and the squeeze: their average, its interval, and the scores."""

import numpy as np
import pytest

from firstcontact.core import Dataset
from firstcontact.jobs import Serial
from firstcontact.twin import CONDITIONS
from firstcontact_lab.report.results import NOTHING
from firstcontact_lab.study.grasps import (
    EVERYDAY,
    FEATURES,
    OWN,
    RANDOM,
    SQUEEZES,
    GraspLaw,
    Sizes,
    SqueezeScale,
    grasps,
    squeeze_features,
)
from firstcontact_lab.study.part import StudySettings, Subject
from firstcontact_lab.study.parts.whole_grasp import FIRST, METHODS, PART, WHOLE_GRASP, measure

RNG = np.random.default_rng(5)
N = 4000
TRUTH = RNG.uniform(30, 60, N)
GAPS = RNG.gamma(2.5, 0.006, N)
SHARED = RNG.standard_normal(N)


def _known(drift: float, softer: float) -> tuple[np.ndarray, np.ndarray]:
    """Return estimates of known errors: correlation 0.5 of the fingers, SD 4 and 6, squeeze 8."""
    own = RNG.standard_normal((N, 3))
    first = 4 * (np.sqrt(0.5) * SHARED + np.sqrt(0.5) * own[:, 0])
    second = 6 * (np.sqrt(0.5) * SHARED + np.sqrt(0.5) * own[:, 1])
    late = drift * (GAPS - GAPS.mean())
    values = TRUTH[:, None] + np.column_stack([first, second + late, 8 * own[:, 2] - softer])
    return values, np.tile([2.0, 6.0, 3.0], (N, 1))


@pytest.mark.parametrize(("drift", "softer"), [(300.0, 0.0), (-150.0, 10.0)])
def test_a_law_of_known_errors_is_measured_and_averages_better_than_each(
    drift: float, softer: float
) -> None:
    values, spreads = _known(drift, softer)
    law = GraspLaw.measure(values, spreads, GAPS, TRUTH)
    assert law.drift == pytest.approx(drift, rel=0.15)
    assert law.softer == pytest.approx(-softer, abs=0.5)
    assert law.errors == pytest.approx((4.0, 6.0), rel=0.05)
    assert law.scales == pytest.approx((2.0, 1.0), rel=0.05)
    assert np.hypot(law.structure, 3.0) == pytest.approx(8.0, rel=0.05)
    assert law.correlations == pytest.approx((0.5, 0.0, 0.0), abs=0.06)
    first = values[:, 0], values[:, 0] - 6.6, values[:, 0] + 6.6
    value, low, high = law.sharpen(values, spreads, GAPS, first)
    errors = np.sqrt(np.mean((law.corrected(values, GAPS) - TRUTH[:, None]) ** 2, axis=0))
    assert np.sqrt(np.mean((value - TRUTH) ** 2)) < 0.95 * errors.min()
    assert np.mean((low <= TRUTH) & (high >= TRUTH)) == pytest.approx(0.9, abs=0.01)


def test_the_first_finger_alone_keeps_its_estimate_and_a_missing_finger_gets_no_weight() -> None:
    values, spreads = _known(0.0, 0.0)
    law = GraspLaw.measure(values, spreads, GAPS, TRUTH)
    first = values[:, 0], values[:, 0] - 1, values[:, 0] + 2
    alone = np.where([True, False, False], values, np.nan)
    for out, given in zip(law.sharpen(alone, spreads, GAPS, first), first, strict=True):
        np.testing.assert_array_equal(out, given)
    squeezed = np.where([True, False, True], values, np.nan)
    value, sd = law.combine(squeezed, spreads)
    assert np.isfinite(value).all()
    assert (sd < 4.0).all()


def test_a_squeeze_scale_recovers_the_shore_a_of_held_out_sessions() -> None:
    shore_a = np.repeat([10.0, 20.0, 29.0, 43.0, 60.0], 16)
    travel = -0.4 * np.log(shore_a) + 0.02 * RNG.standard_normal(80)
    features = np.column_stack([travel, travel + 0.1, RNG.standard_normal(80)])
    sessions = np.tile([f"day {n}" for n in range(8)], 10)
    scale = SqueezeScale.fit(features, shore_a, sessions)
    assert 0 < scale.error < 6
    soft, stiff = scale.predict(features[[0, -1]])
    assert soft < stiff


def test_features_of_a_squeeze_use_nothing_after_their_time() -> None:
    times, every = np.arange(0, 0.5, 0.005), np.arange(0, 0.5, 1 / 4936)
    positions, cells = 0.1 * times, 3 * np.clip(every - 0.1, 0, 0.1)
    features = squeeze_features(times, positions, every, cells, 0.1, 0.2)
    positions, cells = positions + 9 * (times > 0.2), cells + 9 * (every > 0.2)
    np.testing.assert_array_equal(
        features, squeeze_features(times, positions, every, cells, 0.1, 0.2)
    )
    assert np.exp(features[0]) == pytest.approx(0.01, rel=0.01)


def test_one_seed_gives_the_same_pinches_with_squeezes_only_after_the_second_contact() -> None:
    sizes = Sizes(blocks=2, objects=1, random=3)
    made, again = grasps(4, "everyday", sizes), grasps(4, "everyday", sizes)
    np.testing.assert_array_equal(made.second.signals, again.second.signals)
    np.testing.assert_array_equal(made.squeezes, again.squeezes)
    assert set(made.uses) == {OWN, EVERYDAY, RANDOM}
    assert made.squeezes.shape == (len(SQUEEZES), len(made.gaps), len(FEATURES))
    is_early = made.gaps > 1e-3 * SQUEEZES[0]
    assert np.isnan(made.squeezes[0, is_early]).all()
    assert np.isfinite(made.squeezes[-1]).all()
    assert (made.second.fingers == 1 - made.first.fingers).all()


def test_each_method_is_scored_when_it_has_an_estimate() -> None:
    settings = StudySettings().quick()
    subject = Subject(CONDITIONS["paper-rig"].name, Dataset(()))
    made = measure(subject, settings, Serial())
    results = made.results[WHOLE_GRASP]
    assert results is not None
    assert list(results.methods) == list(METHODS)
    scores = {name: method.scores for name, method in results.methods.items()}
    for ms in FIRST[:2]:
        assert scores["sharpened"][f"{EVERYDAY} {ms} rmse"] == pytest.approx(
            scores["first"][f"{EVERYDAY} {ms} rmse"]
        )
    assert f"{RANDOM} {FIRST[0]} rmse" not in scores["squeeze"]
    # The twin's network is better than a guess, and the stall of the hand is calibrated on blocks.
    assert 3 < scores["sharpened"][f"{EVERYDAY} {SQUEEZES[-1]} rmse"] < 16
    # Spreads of the second finger's estimates have the size of its errors.
    assert 0.6 < results.law.scales[1] < 3
    assert made.figures[0].image.startswith("data:image/svg+xml")
    everyday, random = PART.made_tables(made.results)
    assert len(everyday.lines) == len(random.lines) == 10
    assert measure(Subject("recordings", Dataset(())), settings, Serial()).results is NOTHING
