"""Tests of a pinch that is simulated in pieces, with orders."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from pinches import EVERYDAY, PAPER_RIG, drawn

from firstcontact.core import FINGERTIP_RATE
from firstcontact.twin import (
    BLOCKS,
    EVERYDAY_OBJECTS,
    INDENTATION,
    Condition,
    TwinObject,
    integrate_pinch,
)
from firstcontact.twin._pinch import BURN_IN, DURATION
from firstcontact.twin._run import PinchRun

ALL = BURN_IN + round(DURATION * FINGERTIP_RATE)


def same(a: NDArray[np.float64], b: NDArray[np.float64]) -> bool:
    return a.tobytes() == b.tobytes()


def pieces(run: PinchRun, edges: list[int]) -> NDArray[np.float64]:
    return np.concatenate([run.advance(b - a) for a, b in pairwise(edges) if b > a])


@settings(max_examples=20)
@given(
    st.sampled_from([BLOCKS[0], BLOCKS[4], EVERYDAY_OBJECTS[4]]),
    st.sampled_from([PAPER_RIG, EVERYDAY]),
    st.lists(st.integers(1, ALL - 1), max_size=8),
)
def test_any_pieces_give_the_same_bytes(
    kind: TwinObject, condition: Condition, cuts: list[int]
) -> None:
    run = PinchRun(drawn(kind, 1, condition), DURATION, BURN_IN)
    out = pieces(run, [0, *sorted(cuts), ALL])
    times, expected = integrate_pinch(drawn(kind, 1, condition))
    assert same(out[BURN_IN:], expected)
    assert same(run.times[BURN_IN:] - BURN_IN / FINGERTIP_RATE, times)


@settings(max_examples=20)
@given(st.lists(st.integers(1, ALL - 1), max_size=6), st.sampled_from([0.05, -0.1, 0.0]))
def test_command_takes_effect_at_its_sample_for_any_pieces(cuts: list[int], speed: float) -> None:
    command_sample = 800

    def commanded(edges: list[int]) -> NDArray[np.float64]:
        run = PinchRun(drawn(BLOCKS[2]), DURATION, BURN_IN)
        before_command = pieces(
            run, sorted({0, command_sample, *(e for e in edges if e < command_sample)})
        )
        run.speed = speed
        after_command = pieces(
            run, sorted({command_sample, ALL, *(e for e in edges if e > command_sample)})
        )
        return np.concatenate([before_command, after_command])

    assert same(commanded(cuts), commanded([]))


def test_a_still_run_stays_still() -> None:
    run = PinchRun(drawn(BLOCKS[1]), 0.5, at_rest=True)
    out = run.advance(run.times.size)
    assert not out[..., :INDENTATION].any()
    assert run.touched == (False, False)


@pytest.mark.parametrize("share", [1.0, 0.5, 0.25])
def test_slower_hand_touches_proportionally_later(share: float) -> None:
    timing = drawn(BLOCKS[2], 3).timing
    run = PinchRun(drawn(BLOCKS[2], 3), 1.0, at_rest=True)
    run.speed = share * run.nominal_speed
    closed = run.advance(run.times.size)[..., INDENTATION] > 0
    touched = np.sort(closed.argmax(axis=0)) / FINGERTIP_RATE
    assert touched == pytest.approx(np.array(timing[:2]) / share, abs=1.1 / FINGERTIP_RATE)


def test_pause_delays_the_contact_by_its_length() -> None:
    timing = drawn(BLOCKS[2]).timing
    run = PinchRun(drawn(BLOCKS[2]), 1.0)
    run.advance(300)
    run.speed = 0.0
    paused = run.advance(1000)
    assert not (paused[..., INDENTATION] > 0).any()
    run.speed = run.nominal_speed
    closed = run.advance(1500)[..., INDENTATION] > 0
    contact_time = (1300 + closed.any(axis=1).argmax()) / FINGERTIP_RATE
    assert contact_time == pytest.approx(timing.first + 1000 / FINGERTIP_RATE, abs=1e-3)


def test_motor_noise_follows_the_loudness() -> None:
    run = PinchRun(drawn(BLOCKS[2]), 1.0, at_rest=True)
    quiet = run.advance(1000)[..., 0].std()
    run.loudness = 1.0
    run.advance(500)
    loud = run.advance(1000)[..., 0].std()
    run.loudness = 0.0
    run.advance(1000)
    faded = run.advance(1000)[..., 0].std()
    assert quiet == 0 < loud
    assert faded < 1e-3 * loud


@pytest.mark.parametrize("samples", [0, -1, ALL + 1])
def test_advancing_past_the_end_is_refused(samples: int) -> None:
    with pytest.raises(ValueError, match=f"{samples} samples"):
        PinchRun(drawn(BLOCKS[0]), DURATION, BURN_IN).advance(samples)
