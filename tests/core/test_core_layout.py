"""Columns, units and JSON form of a layout, and blocks, which join without gap or overlap."""

import json
from itertools import pairwise

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from firstcontact.core import (
    Block,
    Channel,
    ChannelKind,
    Finger,
    Layout,
    VibrationSensor,
    fingertip_layout,
    merge_blocks,
)
from firstcontact.core.layout import ADC_COUNTS, ADC_VOLTS, SUBCOUNTS
from firstcontact.core.records import read_record


def channels():
    number = st.floats(-1e6, 1e6)
    return st.builds(
        Channel,
        name=st.text(st.characters(exclude_categories=["Cs"]), max_size=8),
        kind=st.sampled_from(ChannelKind),
        finger=st.none() | st.sampled_from(Finger),
        unit=st.sampled_from(["V", "N", ""]),
        scale=st.floats(1e-9, 1e6) | st.floats(-1e6, -1e-9),
        offset=number,
        taxel=st.none() | st.integers(0, 5),
        smoothing_alpha=st.floats(0.01, 1),
        axes=st.integers(3, 5),
        axis=st.integers(0, 2),
    )


@given(
    st.lists(channels(), max_size=6).map(tuple),
    st.floats(2000, 1e5),
    st.none() | st.floats(0.01, 1),
)
def test_layout_round_trips_through_json(columns, rate, alpha):
    layout = Layout(columns, rate, alpha)
    back = read_record(json.dumps(layout.to_json()).encode(), Layout, "layout", "mend it")
    assert back == layout
    assert all(isinstance(c.kind, ChannelKind) for c in back.channels)
    assert all(c.finger is None or isinstance(c.finger, Finger) for c in back.channels)


def test_fingertip_has_the_channels_of_the_published_hand():
    layout = fingertip_layout()
    assert len(layout.channels) == 16
    assert layout.rate == 4936
    assert [c.smoothing_alpha for c in layout.vibration] == [0.5, 0.5]
    assert {c.sensor for c in layout.vibration} == {VibrationSensor.PIEZO}
    assert layout.vibration_fingers == (Finger.INDEX, Finger.THUMB)
    assert layout.has_strip
    for finger in Finger:
        assert len(layout.columns(ChannelKind.VIBRATION, finger)) == 1
        assert len(layout.columns(ChannelKind.FORCE, finger)) == 6
        assert len(layout.columns(ChannelKind.STRIP, finger)) == 1
    columns = [i for kind in ChannelKind for i in layout.columns(kind)]
    assert sorted(columns) == list(range(16))


def test_counts_convert_to_volts():
    layout = fingertip_layout()
    piezo = layout.columns(ChannelKind.VIBRATION)
    force = layout.columns(ChannelKind.FORCE)
    data = np.zeros((3, 16), dtype=np.int16)
    middle = ADC_COUNTS * SUBCOUNTS // 2
    data[0] = middle
    data[1] = middle + SUBCOUNTS
    np.testing.assert_allclose(layout.physical(data, piezo)[0], 0, atol=1e-12)
    np.testing.assert_allclose(layout.physical(data, piezo)[1], ADC_VOLTS / ADC_COUNTS)
    np.testing.assert_allclose(layout.physical(data, piezo)[2], -ADC_VOLTS / 2)
    np.testing.assert_allclose(layout.physical(data, force)[0], ADC_VOLTS / 2)
    np.testing.assert_allclose(layout.physical(data, force)[2], 0)


def test_columns_keep_the_requested_order():
    layout = fingertip_layout()
    data = np.arange(16, dtype=np.int16)[None, :]
    values = layout.physical(data, (15, 14))
    np.testing.assert_array_equal(values, [[15.0, 14.0]])


STEPS = st.tuples(
    st.integers(1, 9),  # samples
    st.sampled_from([0, 0, 0, 2]),  # missing before them
    st.sampled_from([0, 0, 0, 1]),  # whether an epoch begins with them
    st.sampled_from([2, 2, 2, 3]),  # columns
)


@given(st.lists(STEPS), st.sampled_from([1, 10, np.inf]))
def test_merged_blocks_are_few_and_keep_all_samples(steps, limit):
    blocks, place, epoch = [], 0, 0
    for count, missing, begun, columns in steps:
        place, epoch = place + missing, epoch + begun
        numbers = np.arange(place, place + count)
        blocks.append(Block(np.repeat(numbers[:, None], columns, axis=1), place, epoch))
        place += count
    merged = merge_blocks(blocks, limit)

    def samples(parts):
        return [(b.epoch, tuple(row)) for b in parts for row in b.data.tolist()]

    assert samples(merged) == samples(blocks)
    for block in merged:
        assert block.data[:, 0].tolist() == list(range(block.first_sample, block.end))
        assert len(block.data) <= limit or any(block is original for original in blocks)
    for a, b in pairwise(merged):
        is_break = (a.end, a.epoch, a.data.shape[1]) != (b.first_sample, b.epoch, b.data.shape[1])
        assert is_break or limit < np.inf
