"""The compiled kernels decide as the NumPy code does."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from compiled_kernels import built_kernels, using
from firstcontact.contact import detect
from firstcontact.contact._gate import STEP, ClosingGate
from firstcontact.contact._logistic import LogisticDetector
from firstcontact.core import (
    Block,
    Calibration,
    ChannelKind,
    Finger,
    VibrationCalibration,
    fingertip_layout,
)
from firstcontact.signal import samples_in
from firstcontact.testing import closings
from firstcontact.testing._closings import closing

LAYOUT = fingertip_layout()


def decisions(detector, pinch, size):
    """Return the decisions for all windows of a pinch, in blocks of this size."""
    detector.start(pinch.layout)
    blocks = [Block(pinch.data[i : i + size], i) for i in range(0, len(pinch.data), size)]
    parts = [detector.judge(block) for block in blocks]
    return [np.concatenate([getattr(p, name) for p in parts]) for name in ("fired", "onsets")]


@pytest.mark.parametrize("size", [1, 5, 100, 100_000])
def test_windows_are_judged_as_by_numpy(fitted, size):
    fired = 0
    for pinch in closings(4, seed=7).pinches:
        compared = []
        for module in (built_kernels(), None):
            with using(module):
                compared.append(decisions(fitted["logistic"], pinch, size))
        for a, b in zip(*compared, strict=True):
            np.testing.assert_array_equal(a, b)
        fired += compared[0][0].sum()
    assert fired


def test_onsets_in_noise_are_those_of_numpy(fitted):
    """Without a contact no onset stands out, so each term of its score counts."""
    arrays = fitted["logistic"].to_arrays()
    arrays["line"] = np.append(arrays["line"][:-1], 1e6)  # each window fires
    detector = LogisticDetector.from_arrays(arrays)
    with using(built_kernels()):
        fired, compiled = decisions(detector, closing(3), 5)
    with using(None):
        plain = decisions(detector, closing(3), 5)[1]
    assert fired.sum() > 50
    np.testing.assert_array_equal(compiled, plain)


def test_a_constant_channel_never_fires(fitted):
    pinch = closing(3)
    pinch.data[:, 0] = 16384
    with using(built_kernels()):
        compiled = decisions(fitted["logistic"], pinch, 5)[0]
    with using(None):
        plain = decisions(fitted["logistic"], pinch, 5)[0]
    np.testing.assert_array_equal(compiled, plain)
    assert not compiled[:, 0].any()


def test_contacts_are_those_of_numpy(fitted):
    for seed in range(20):
        with using(built_kernels()):
            contacts = detect(fitted["logistic"], closing(seed))
        with using(None):
            assert contacts == detect(fitted["logistic"], closing(seed))


def test_a_subclass_judges_by_its_own_rule(fitted):
    class Deaf(LogisticDetector):
        name = "deaf"

        def fires(self, windows):
            return np.zeros(windows.shape[:2], np.bool_)

    with using(built_kernels()):
        assert detect(fitted["logistic"], closing(5))
        assert not detect(Deaf.from_arrays(fitted["logistic"].to_arrays()), closing(5))


def test_a_detector_that_was_used_can_be_copied(fitted):
    with using(built_kernels()):
        expected = detect(fitted["logistic"], closing(5))
        for again in (
            copy.deepcopy(fitted["logistic"]),
            pickle.loads(pickle.dumps(fitted["logistic"])),
        ):
            assert detect(again, closing(5)) == expected


@settings(max_examples=30)
@given(
    seed=st.integers(0, 2**32 - 1),
    parts=st.lists(st.tuples(st.floats(0.2, 3.0), st.integers(1, 60)), min_size=2, max_size=8),
    size=st.integers(1, 200),
)
def test_the_gate_turns_where_that_of_numpy_does(seed, parts, size):
    rng = np.random.default_rng(seed)
    step = samples_in(STEP, LAYOUT.rate)
    loudness = np.concatenate([np.full(n * step, level) for level, n in parts])
    data = np.zeros((len(loudness), LAYOUT.width), np.int16)
    columns = LAYOUT.columns(ChannelKind.VIBRATION)
    for c in columns:
        data[:, c] = 16384 + 60 * loudness * rng.standard_normal(len(loudness))
    volts = 60 * LAYOUT.column_channels[columns[0]].scale
    floors = Calibration(tuple(VibrationCalibration(f, volts) for f in Finger))
    turns = []
    for module in (built_kernels(), None):
        gate = ClosingGate(LAYOUT, floors)
        with using(module):
            blocks = (Block(data[i : i + size], i) for i in range(0, len(data), size))
            turns.append([event for block in blocks for event in gate.update(block)])
    assert turns[0] == turns[1]


@pytest.mark.parametrize("seed", range(20))
def test_the_gate_turns_alike_with_samples_that_are_not_numbers(seed):
    rng = np.random.default_rng(seed)
    loudness = np.repeat(rng.choice([0.5, 20.0], 40), 50)
    data = np.zeros((len(loudness), LAYOUT.width))
    columns = list(LAYOUT.columns(ChannelKind.VIBRATION))
    data[:, columns] = 16384 + 60 * loudness[:, None] * rng.standard_normal((len(data), 2))
    data[rng.integers(0, len(data), 3), columns[0]] = np.nan
    volts = 60 * LAYOUT.column_channels[columns[0]].scale
    floors = Calibration(tuple(VibrationCalibration(f, volts) for f in Finger))
    turns = []
    for module in (built_kernels(), None):
        with using(module):
            turns.append(list(ClosingGate(LAYOUT, floors).update(Block(data))))
    assert turns[0] == turns[1]
