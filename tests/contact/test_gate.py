"""The gate opens once per closing for any block sizes, and never for rest, knocks or opening."""

import numpy as np
import pytest
from hand_stream import (
    FLOOR,
    LAYOUT,
    OPENS,
    SHUTS,
    Turn,
    hand_stream,
    make_gate,
    raw,
    samples,
    turns,
)
from hypothesis import given
from hypothesis import strategies as st

from firstcontact.core import Block, Calibration, Finger, VibrationCalibration

DATA, CLOSINGS = hand_stream(6)


def run(data: np.ndarray) -> list[Turn]:
    return turns(make_gate(), Block(data))


WHOLE = run(DATA)


def test_opens_once_per_closing_before_the_contact() -> None:
    opened = [sample for turn, sample in WHOLE if turn == OPENS]
    # The opening hand runs its motor too; nothing touches then, and nothing is missed.
    for closing in CLOSINGS:
        inside = [s for s in opened if closing.motor < s < closing.first]
        assert len(inside) == 1
        assert inside[0] - closing.motor <= samples(0.065)
    during_hold = [s for s in opened if any(c.first <= s < c.release for c in CLOSINGS)]
    assert during_hold == []


def test_stays_shut_while_an_object_is_held() -> None:
    x = np.zeros((samples(1.5), 6))
    x[:, :2] = FLOOR * np.random.default_rng(3).standard_normal((len(x), 2))
    motor, release = samples(0.5), samples(1.0)
    x[motor:, :2] *= 3
    x[motor:release, 2:4] = 1
    ((turn, opened),) = run(raw(x))
    assert turn == OPENS
    assert release < opened <= release + samples(0.045)


@given(load=st.booleans(), size=st.integers(1, 5000))
def test_motor_starts_under_a_load_are_counted_until_it_opens(load: bool, size: int) -> None:
    """A force that shifts during a session looks like an object that is held for ever."""
    starts = 3
    x = np.zeros((starts * samples(1.0), 6))
    x[:, :2] = FLOOR * np.random.default_rng(3).standard_normal((len(x), 2))
    x[np.arange(len(x)) % samples(1.0) > samples(0.5), :2] *= 3
    rest, data = x[: samples(0.4)].copy(), x.copy()
    data[:, 2:4] = load
    gate = make_gate()
    gate.take(Block(raw(rest)))
    data = raw(np.concatenate([data, rest]))
    for k in range(0, len(data), size):
        gate.take(Block(data[k : k + size], len(rest) + k))
    assert gate.refused == (starts if load else 0)
    gate.take(Block(raw(x[: samples(0.9)]), len(rest) + len(data)))
    assert gate.refused == 0


def test_a_knock_at_rest_does_not_open_it() -> None:
    rng = np.random.default_rng(1)
    data = np.array(DATA[:1])
    data = np.repeat(data, samples(1.0), axis=0)
    data[:, :2] = LAYOUT.channels[0].offset
    noise = FLOOR / LAYOUT.channels[0].scale * rng.standard_normal((len(data), 2))
    noise[samples(0.5) : samples(0.505)] += 5000
    data[:, :2] = (data[:, :2] + noise).astype(np.int16)
    assert run(data) == []


def test_gap_shuts_the_gate_until_the_next_quiet_period() -> None:
    gate = make_gate()
    opened = next(sample for turn, sample in WHOLE if turn == OPENS)
    cut = opened + 20
    assert turns(gate, Block(DATA[:cut]))[-1] == (OPENS, opened)
    events = turns(gate, Block(DATA[cut + 10 : CLOSINGS[0].second], cut + 10))
    assert events == [(SHUTS, cut)]


@pytest.mark.parametrize("gap", [1, 7, 15, 44])
def test_closings_after_a_gap_open_at_the_same_samples(gap: int) -> None:
    """If the gate opened at other samples, all contacts after the gap would differ, too."""
    opens = [event for event in WHOLE if event[0] == OPENS]
    cut = opens[0][1] + 20
    for size in (5, 1000):
        gate = make_gate()
        gate.take(Block(DATA[:cut]))
        starts = range(cut + gap, len(DATA), size)
        events = [e for k in starts for e in turns(gate, Block(DATA[k : k + size], k))]
        later_opens = [event for event in events if event[0] == OPENS]
        # One or two are over before it knows rest again, and what is held at the first of the
        # others is not known yet.
        assert len(later_opens) >= len(opens) - 3
        assert later_opens[1:] == opens[1 - len(later_opens) :]
        assert all(sample % samples(0.003) == 0 for _, sample in later_opens)


def test_new_epoch_shuts_the_gate_at_the_end_of_the_old_one() -> None:
    gate = make_gate()
    opened = next(sample for turn, sample in WHOLE if turn == OPENS)
    gate.take(Block(DATA[: opened + 7]))
    assert turns(gate, Block(DATA[:100], 0, epoch=1)) == [(SHUTS, opened + 7)]


@pytest.mark.parametrize(
    "calibration", [None, Calibration((VibrationCalibration(Finger.INDEX, FLOOR),))]
)
def test_epoch_without_noise_floors_is_one_closing(calibration: Calibration | None) -> None:
    gate = make_gate(calibration)
    assert turns(gate, Block(DATA[:50], 7)) == [(OPENS, 7)]
    assert turns(gate, Block(DATA[50:90], 57)) == []
    # After a gap the steady state would be of an unknown phase: not before the next epoch.
    assert turns(gate, Block(DATA[100:200], 107)) == [(SHUTS, 97)]
    assert turns(gate, Block(DATA[:50], 0, epoch=1)) == [(OPENS, 0)]
