"""Tests of the microcontroller's filters against a simple reference, for all block sizes."""

import math
from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray
from pinches import drawn, simulated

from firstcontact.core.layout import ADC_COUNTS, SUBCOUNTS, TAXELS
from firstcontact.twin import BLOCKS
from firstcontact.twin.pinch import integrate_pinch
from firstcontact.twin.sensor import (
    FORCE_READINGS,
    ROUND,
    DeviceFilter,
    PinchFingertips,
    open_reading,
    smoothed,
)

TOP = (ADC_COUNTS - 1) * SUBCOUNTS


def random_scans(seed: int, n: int) -> NDArray[np.uint16]:
    rng = np.random.default_rng(seed)
    scans = rng.integers(0, ADC_COUNTS, (n, 6)).astype(np.uint16)
    scans[:, 4:] = rng.integers(0, 2, (n, 2))
    return scans


def reference(scans: NDArray[np.uint16]) -> list[list[int]]:
    """Filter scans with a simple implementation."""
    out = []
    for i, scan in enumerate(scans.tolist()):
        row, means = [0] * 16, [0] * TAXELS
        for f in range(2):
            row[f] = scan[f] * SUBCOUNTS if i == 0 else (out[-1][f] + scan[f] * SUBCOUNTS) // 2
            for k in range(TAXELS):
                readings = scans[k : i + 1 : TAXELS, 2 + f].tolist()
                if readings:
                    recent = ([readings[0]] * FORCE_READINGS + readings)[-FORCE_READINGS:]
                    means[k] = sum(recent) * SUBCOUNTS // FORCE_READINGS
            for k, mean in enumerate(means):
                # Exact share of the supply alone in the column, rounded half up.
                left = ADC_COUNTS * SUBCOUNTS - sum(means[k % 2 :: 2]) + mean
                alone = Fraction(mean, max(left, 1)) * ADC_COUNTS * SUBCOUNTS
                row[2 + 6 * f + k] = min(math.floor(alone + Fraction(1, 2)), TOP)
            row[14 + f] = scan[4 + f]
        out.append(row)
    return out


@given(st.integers(0, 2**32 - 1), st.lists(st.integers(0, 200), max_size=6))
def test_any_blocks_give_the_output_of_the_reference(seed: int, cuts: list[int]) -> None:
    scans = random_scans(seed, 200)
    device = DeviceFilter()
    edges = [0, *sorted(cuts), 200]
    out = np.concatenate([device.update(scans[a:b]) for a, b in pairwise(edges)])
    assert out.dtype == np.int16
    assert out.tolist() == reference(scans)


@given(arrays(np.uint16, (60, 6), elements=st.sampled_from([0, 5, ADC_COUNTS - 1, 1024, 65_535])))
def test_output_of_any_scans_is_in_range(scans: NDArray[np.uint16]) -> None:
    out = DeviceFilter().update(scans)
    assert 0 <= out.min() <= out.max() <= TOP
    possible = np.minimum(scans, ADC_COUNTS - 1)
    possible[:, 4:] = scans[:, 4:] != 0
    assert out.tolist() == reference(possible)


def test_restart_clears_the_filter() -> None:
    scans = random_scans(3, 100)
    device = DeviceFilter()
    device.update(random_scans(4, 77))
    device.reset()
    assert (device.update(scans) == DeviceFilter().update(scans)).all()


def test_scans_of_another_shape_are_refused() -> None:
    with pytest.raises(ValueError, match=r"\(5, 16\)"):
        DeviceFilter().update(np.zeros((5, 16), np.uint16))


def test_simulated_pinch_equals_its_filtered_scans() -> None:
    draw = drawn(BLOCKS[1])
    times, motion = integrate_pinch(draw)
    scans = PinchFingertips(draw, times).read(motion)
    open_hand = np.repeat(scans[:1], ROUND, axis=0)
    open_hand[:, 2:4] = [open_reading(v) for v in draw.velostat]
    out = DeviceFilter().update(np.concatenate([open_hand, scans]))[ROUND:]
    assert (simulated(BLOCKS[1]).data == out).all()


def test_single_piezo_is_smoothed_as_on_the_device() -> None:
    scans = random_scans(3, 500)
    assert smoothed(scans[:, 0]).tolist() == DeviceFilter().update(scans)[:, 0].tolist()
