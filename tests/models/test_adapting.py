"""Adaptation to a rig: fingers, held-out pinches, refusals and intervals."""

import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from firstcontact.core import InputError
from firstcontact.models import Task, Touches
from firstcontact.models.model_file import pretrained
from firstcontact.models.rig.network_estimator import (
    LEAST_OF_FINGER,
    MOST_OF_LEVEL,
    NARROWEST,
    HeldOut,
    NetworkEstimator,
    adapt_network,
)
from firstcontact.models.rig.rig_model import RigModel
from firstcontact.models.rig.rigs import Rig
from firstcontact.signal import samples_in
from ringing import ringing

pytestmark = pytest.mark.usefixtures("stored_detectors")

BASE = pretrained()


def two_fingers(gain: float, n: int = 120) -> tuple[Touches, np.ndarray, np.ndarray]:
    """Return contacts of both fingers in turn. The second sensor has another gain."""
    touches, shore_a, sessions = ringing(n)
    fingers = np.arange(n) // 5 % 2
    signals = touches.signals * np.where(fingers == 1, gain, 1.0)[:, None]
    return replace(touches, fingers=fingers, signals=signals.astype(np.float32)), shore_a, sessions


def test_each_finger_with_enough_pinches_is_a_rig() -> None:
    touches, shore_a, sessions = two_fingers(25.0)
    rigs = adapt_network(BASE, touches, shore_a, sessions).model.rigs
    assert set(rigs) == {Rig.ANY, 0, 1}
    assert rigs[1].level == pytest.approx(25 * rigs[0].level, rel=0.3)
    few = np.flatnonzero(touches.fingers == 1)[LEAST_OF_FINGER - 1 :]
    rest = np.setdiff1d(np.arange(len(touches)), few)
    made = adapt_network(BASE, touches.take(rest), shore_a[rest], sessions[rest])
    assert set(made.model.rigs) == {Rig.ANY, 0}


def test_whole_sessions_are_held_out() -> None:
    """The sessions have different levels, so errors are large if a whole session is held out."""
    touches, shore_a, sessions = two_fingers(1.0)
    shifted = shore_a.copy()
    for number, name in enumerate(np.unique(sessions)):
        shifted[sessions == name] = np.roll(shore_a[sessions == name], number)
    mixed = adapt_network(BASE, touches, shifted, None)
    model = adapt_network(BASE, touches, shifted, sessions)
    assert mixed.scores != model.scores


def test_random_pinches_are_held_out_if_each_session_has_one_level() -> None:
    touches, shore_a, _ = ringing(120, levels=(30.0, 70.0))
    made = adapt_network(BASE, touches, shore_a, shore_a.astype(str))
    assert made.scores == adapt_network(BASE, touches, shore_a).scores
    assert made.split
    shuffled = np.random.default_rng(0).permutation(shore_a)
    assert adapt_network(BASE, touches, shuffled, shuffled.astype(str)).why_useless


def test_one_level_or_three_pinches_are_too_few() -> None:
    touches, shore_a, _ = two_fingers(1.0)
    with pytest.raises(InputError, match="2 values of Shore A"):
        adapt_network(BASE, touches, np.full(len(touches), 20.0))
    with pytest.raises(InputError, match="more flat blocks"):
        adapt_network(BASE, touches.take(np.arange(3)), shore_a[:3])
    # Too short to be used is as good as not there.
    with pytest.raises(InputError, match="more flat blocks"):
        adapt_network(BASE, touches.until(BASE.shortest - 1), shore_a)


def test_scores_no_better_than_the_mean_are_a_reason_to_refuse() -> None:
    touches, shore_a, sessions = ringing(120)
    assert not adapt_network(BASE, touches, shore_a, sessions).why_useless
    shuffled = np.random.default_rng(0).permutation(shore_a)
    made = adapt_network(BASE, touches, shuffled, sessions)
    assert made.scores[made.model.kind] > made.mean_rmse
    assert f"{made.mean_rmse:.1f}" in made.why_useless


def coverage(model: RigModel, touches: Touches, truth: np.ndarray) -> np.ndarray:
    """Return the share of truths in the intervals at each time."""
    by_time = [
        model.predict_touches(touches.until(samples_in(1e-3 * ms, touches.rate)))
        for ms in Touches.SCORED_MS
    ]
    return np.array([np.mean((a.low <= truth) & (truth <= a.high)) for a in by_time])


def test_intervals_that_hold_too_few_held_out_pinches_are_widened() -> None:
    """The signals differ from the network's training signals."""
    levels, means = (10.0, 40.0, 90.0), []
    for seed in range(4):
        made = adapt_network(BASE, *ringing(120, seed, levels=levels))
        assert made.check.coverage < BASE.level
        assert (made.check.scales >= 1).all()
        fresh, truth, _ = ringing(300, seed + 50, levels=levels)
        original, current = (
            coverage(m, fresh, truth) for m in (BASE.conditioned_on(made.model.rigs), made.model)
        )
        assert (current >= original).all()
        assert current.mean() > original.mean() + 0.03
        means.append(current.mean())
    assert np.mean(means) > 0.8


def test_intervals_of_the_network_with_enough_coverage_stay_unchanged() -> None:
    wide = BASE.rescaled(np.full(len(Rig.STAGES), 3.0))
    made = adapt_network(wide, *ringing(120, levels=(38.0, 42.0)))
    assert made.check.coverage >= wide.level
    np.testing.assert_array_equal(made.model.factors, wide.factors)


@given(arrays(float, (5, 40), elements=st.floats(0.0, 10.0)), st.booleans())
def test_scaled_intervals_hold_the_held_out_pinches(ratios: np.ndarray, is_average: bool) -> None:
    """However narrow intervals become, they hold the stated share of the rig's own pinches."""
    rows = np.arange(ratios.shape[1])
    check = HeldOut(ratios, rows.astype(float), np.ones_like(ratios), rows).check(
        BASE.level, BASE.rate, is_average
    )
    assert (check.scales >= (NARROWEST if is_average else 1.0)).all()
    at_times = np.interp(Rig.stages_at_scored_times(BASE.rate), Rig.STAGES, check.scales)
    assert ((ratios <= at_times[:, None] * (1 + 1e-9)).mean(axis=1) >= BASE.level).all()


def test_no_more_pinches_of_a_level_are_used_than_in_training() -> None:
    made = adapt_network(BASE, *two_fingers(1.0, 300))
    for rig in made.model.rigs.values():
        counts = np.exp(2 * (rig.tokens[0, :, 1] + 1))
        assert counts == pytest.approx(MOST_OF_LEVEL)


def test_stated_coverage_is_not_too_large_and_stated_widening_not_too_small() -> None:
    rig = ringing(120, levels=(20.0, 60.0))
    check = adapt_network(BASE, *rig).check
    sentences = NetworkEstimator(Task.REGRESSION, BASE.rate).fit(*rig)[1]
    pattern = r"at least ([\d.]+) % .* multiplied by ([\d.]+) to ([\d.]+)$"
    stated = re.search(pattern, sentences[-1])
    share, least, scale = map(float, stated.groups())
    assert share <= 100 * check.coverage < share + 0.1
    assert least <= check.scales.min() < least + 0.01
    assert scale - 0.01 < check.scales.max() <= scale
