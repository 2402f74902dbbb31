"""Filters, scan order and timing of the C core, compared with the twin and with closed forms."""

import itertools
import re
from pathlib import Path

import numpy as np
import pytest
from firmware_core import Core
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray

from firstcontact.core.layout import ADC_COUNTS, FINGERTIP_RATE
from firstcontact.twin.sensor import DeviceFilter

COUNTS = st.one_of(st.integers(0, ADC_COUNTS - 1), st.integers(0, 0xFFFF))
RAILS = st.sampled_from([0, ADC_COUNTS - 1])
SHAPES = st.tuples(st.integers(1, 120), st.just(6))


def with_strips(scans: NDArray[np.uint16]) -> NDArray[np.uint16]:
    scans[:, 4:] &= 1
    return scans


@given(
    scans=st.one_of(
        arrays(np.uint16, SHAPES, elements=COUNTS), arrays(np.uint16, SHAPES, elements=RAILS)
    )
)
@settings(max_examples=60)
def test_filters_equal_the_twins_bit_for_bit(core: Core, scans: NDArray[np.uint16]) -> None:
    scans = with_strips(scans)
    np.testing.assert_array_equal(core.filtered(scans), DeviceFilter().update(scans))


def test_scan_goes_row_by_row(core: Core) -> None:
    expected = [(i % 6 // 2, i % 6 % 2) for i in range(25)]
    assert core.taxels(25) == expected


@pytest.mark.parametrize("clock", [600_000_000, 25_000_000, 24_000_000, 4936, 5000])
def test_samples_of_one_second_last_one_second_to_the_tick(core: Core, clock: int) -> None:
    rate = int(FINGERTIP_RATE)
    periods = core.periods(clock, rate, 3 * rate)
    assert set(periods) <= {clock // rate, clock // rate + 1}
    ends = [0, *itertools.accumulate(periods)]
    assert {b - a for a, b in zip(ends, ends[rate:], strict=False)} == {clock}


@given(clock=st.integers(1, 2**32 - 1), rate=st.integers(1, 2**31 - 1))
def test_no_sample_is_off_by_a_tick(core: Core, clock: int, rate: int) -> None:
    if clock < rate:
        clock, rate = rate, clock
    ends = itertools.accumulate(core.periods(clock, rate, 50))
    assert all(end == (n + 1) * clock // rate for n, end in enumerate(ends))


def test_firmware_and_twin_sample_at_the_rate_of_the_layout() -> None:
    sources = {
        "firmware/core/fc_pace.h": "FC_RATE_HZ",
        "src/firstcontact/twin/c/fingertips.c": "RATE",
    }
    for path, name in sources.items():
        text = (Path(__file__).parents[2] / path).read_text(encoding="utf-8")
        found = re.search(rf"\b{name} = ([\d.]+)", text)
        assert float(found[1]) == FINGERTIP_RATE
