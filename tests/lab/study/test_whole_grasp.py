"""Estimates from both fingers and the squeeze: their average, its interval, and the scores."""

from dataclasses import replace

import numpy as np
import pytest

from firstcontact.core import ArgumentError, Dataset, Label
from firstcontact.jobs import Serial
from firstcontact.twin import BLOCKS, CONDITIONS, draw_pinch, simulate_pinch
from firstcontact.twin.pinch import excerpt
from firstcontact_lab.report.results import NOTHING
from firstcontact_lab.study.grasps import (
    FEATURES,
    LONGEST_GAP,
    SECOND,
    SQUEEZES,
    GraspLaw,
    Sizes,
    SqueezeScale,
    grasps,
    pinch_squeeze,
    squeeze_features,
)
from firstcontact_lab.study.part import StudySettings, Subject
from firstcontact_lab.study.parts.whole_grasp import (
    FIRST,
    METHODS,
    PART,
    SENSORS,
    TIMES,
    WHOLE_GRASP,
    _Estimates,
    measure,
    measure_laws,
)
from firstcontact_lab.study.random_rigs import EVERYDAY, OWN, RANDOM

RNG = np.random.default_rng(5)
N = 4000
TRUTH = RNG.uniform(30, 60, N)
GAPS = RNG.gamma(2.5, 0.006, N)
SHARED = RNG.standard_normal(N)


def known(drift: float, softer: float) -> _Estimates:
    """Return estimates of known errors: correlation 0.5 of the fingers, SD 4 and 6, squeeze 8."""
    own = RNG.standard_normal((N, 3))
    first = TRUTH + 4 * (np.sqrt(0.5) * SHARED + np.sqrt(0.5) * own[:, 0])
    second = TRUTH + 6 * (np.sqrt(0.5) * SHARED + np.sqrt(0.5) * own[:, 1])
    squeeze = np.tile(TRUTH + 8 * own[:, 2] - softer, (len(SQUEEZES), 1, 1))
    return _Estimates(
        np.tile([first, np.full(N, 2.0), first - 3, first + 3], (len(FIRST), 1, 1)),
        second + drift * (GAPS - GAPS.mean()),
        squeeze,
        squeeze,
        GAPS,
        TRUTH,
        np.where(np.arange(N) % 2, EVERYDAY, RANDOM),
        0.0,
    )


@pytest.mark.parametrize(("drift", "softer"), [(300.0, 0.0), (-150.0, 10.0)])
def test_laws_of_known_errors_average_better_than_each_estimate(
    drift: float, softer: float
) -> None:
    pinches = known(drift, softer)
    fitted = pinches.take(RANDOM)
    laws = measure_laws(fitted)
    ms = SQUEEZES[-1]
    errors = {}
    for name in METHODS:
        value, low, high = pinches.predict(name, ms, laws)
        errors[name] = np.sqrt(np.mean((value - TRUTH) ** 2))
        inside = np.mean((low <= TRUTH) & (high >= TRUTH))
        assert name == "first" or inside == pytest.approx(0.9, abs=0.015)
    # The line of the classical method removes its bias, and its excess of scale.
    value, _, _ = fitted.predict("squeeze", ms, laws)
    assert np.mean(value - fitted.shore_a) == pytest.approx(0, abs=0.1)
    assert errors["squeeze"] < min(8.0, TRUTH.std())
    assert errors["sharpened"] < 0.97 * errors["fingers"]
    assert errors["fingers"] < errors["first"] == pytest.approx(4.0, rel=0.05)


def test_a_law_recovers_weights_and_keeps_the_mean_unless_it_shifts() -> None:
    estimate, evidence = TRUTH + 3.0, RNG.standard_normal((N, 2)) + 7
    estimate = estimate - evidence @ np.array([2.0, 0.0]) + 14
    kept, shifted = (
        GraspLaw.measure(estimate, np.ones(N), evidence, TRUTH, shifts=shifts)
        for shifts in (False, True)
    )
    assert kept.weights == pytest.approx([2.0, 0.0], abs=1e-6)
    assert np.mean(kept.value(estimate, evidence) - estimate) == pytest.approx(0, abs=1e-6)
    np.testing.assert_allclose(shifted.value(estimate, evidence), TRUTH, atol=1e-6)


def test_the_first_finger_alone_keeps_its_estimate() -> None:
    pinches = known(0.0, 0.0)
    laws = measure_laws(pinches)
    for ms in FIRST:
        alone = 1e3 * (pinches.gaps + SECOND) > ms
        assert alone.any()
        first = pinches.predict("first", ms, laws)
        for name in ("fingers", "sharpened"):
            for made, given in zip(pinches.predict(name, ms, laws), first, strict=True):
                np.testing.assert_array_equal(made[alone], given[alone])


def test_a_squeeze_scale_recovers_the_shore_a_of_held_out_sessions() -> None:
    shore_a = np.repeat([10.0, 20.0, 29.0, 43.0, 60.0], 16)
    travel = -0.4 * np.log(shore_a) + 0.02 * RNG.standard_normal(80)
    features = np.column_stack([travel, travel + 0.1, RNG.standard_normal(80)])
    held_out = np.arange(80) % 8 == 7
    scale = SqueezeScale.fit(features[~held_out], shore_a[~held_out])
    errors = scale.predict(features[held_out]) - shore_a[held_out]
    assert np.sqrt(np.mean(errors**2)) < 6
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


def test_a_recorded_pinch_gives_the_features_of_its_squeeze() -> None:
    draw = excerpt(draw_pinch(3, CONDITIONS["paper-rig"], "day", BLOCKS[2], "pinch"), 0.045)
    pinch = simulate_pinch(draw, Label("block", 29.0), duration=0.3)
    first, second = (contact.sample / pinch.layout.rate for contact in pinch.truth)
    times = np.arange(0, 0.3, 0.005)
    early, late = (np.exp(pinch_squeeze(pinch, times, 0.1 * times, ms)) for ms in (100, 200))
    assert early[0] == pytest.approx(0.1 * (first + 0.1 - second), rel=0.08)
    assert late[0] - early[0] == pytest.approx(0.01, abs=1e-3)
    assert late[2] > 0.02
    moved = [replace(c, sample=c.sample + 700, decided=c.decided + 700) for c in pinch.truth]
    later = replace(pinch, first_sample=700, truth=tuple(moved))
    np.testing.assert_allclose(np.exp(pinch_squeeze(later, times, 0.1 * times, 200)), late)
    gap = 1e3 * (second - first)
    for ms in (gap - 1, 290):
        with pytest.raises(ArgumentError, match=rf"^ms: .*{gap:.0f} \(second contact\)"):
            pinch_squeeze(pinch, times, 0.1 * times, ms)
    with pytest.raises(ArgumentError, match=r"^ms: "):
        pinch_squeeze(pinch, times[:20], times[:20], 200)
    with pytest.raises(ArgumentError, match=r"^pinch: it has 1 contacts"):
        pinch_squeeze(replace(pinch, truth=pinch.truth[:1]), times, 0.1 * times, 200)


def test_one_seed_gives_the_same_pinches_and_each_has_every_estimate() -> None:
    sizes = Sizes(blocks=2, objects=1, random=3)
    made, again = grasps(4, "everyday", sizes), grasps(4, "everyday", sizes)
    np.testing.assert_array_equal(made.second.signals, again.second.signals)
    np.testing.assert_array_equal(made.squeezes, again.squeezes)
    assert set(made.uses) == {OWN, EVERYDAY, RANDOM}
    assert made.squeezes.shape == (len(SQUEEZES), len(made.gaps), len(FEATURES))
    assert np.isfinite(made.squeezes).all()
    assert np.isfinite(made.exact).all()
    assert made.gaps.max() <= LONGEST_GAP + 0.004  # contacts are placed with random delays
    assert made.left_out > 0
    assert (made.second.fingers == 1 - made.first.fingers).all()


def test_each_method_is_scored_when_it_has_an_estimate() -> None:
    settings = StudySettings().quick()
    subject = Subject(CONDITIONS["paper-rig"].name, Dataset(()))
    made = measure(subject, settings, Serial())
    results = made.results[WHOLE_GRASP]
    assert results is not None
    assert list(results.methods) == list(METHODS) == ["first", *results.pooled]
    assert results.laws.keys() == results.pooled_laws.keys()
    scores = {name: method.scores for name, method in results.methods.items()}
    assert scores["sharpened"][f"{EVERYDAY} {FIRST[0]} rmse"] == pytest.approx(
        scores["first"][f"{EVERYDAY} {FIRST[0]} rmse"]
    )
    for name in METHODS:
        times = SQUEEZES if name in SENSORS else TIMES
        keys = {f"{use} {ms} rmse" for use in (EVERYDAY, RANDOM) for ms in times}
        assert {key for key in scores[name] if key.endswith("rmse")} == keys
        if name != "first":
            assert results.pooled[name].scores.keys() == scores[name].keys()
            assert results.pooled[name].scores != scores[name]
    # The twin's network is better than a guess, and the stall of the hand is calibrated on blocks.
    assert 3 < scores["sharpened"][f"{EVERYDAY} {SQUEEZES[-1]} rmse"] < 16
    # The squeeze reads objects too soft by the scale of blocks.
    assert results.softer < 0
    assert made.figures[0].image.startswith("data:image/svg+xml")
    everyday, random = PART.made_tables(made.results)
    assert len(everyday.lines) == len(random.lines) == 15
    assert measure(Subject("recordings", Dataset(())), settings, Serial()).results is NOTHING
