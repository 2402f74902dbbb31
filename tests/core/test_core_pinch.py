"""Pinches and datasets: labels, offsets, selection."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from firstcontact.core import (
    Block,
    Channel,
    ChannelKind,
    ClosingSpeed,
    Contact,
    Dataset,
    Finger,
    Group,
    InputError,
    Label,
    Layout,
    Pinch,
    Role,
    fingertip_layout,
)
from firstcontact.core.pinch import FASTEST, SLOWEST, first_closed_sample
from firstcontact.core.records import read_record


def pinch(label, *samples):
    truth = tuple(Contact(Finger(i % 2), s, s) for i, s in enumerate(samples))
    return Pinch(np.zeros((10, 16), dtype=np.int16), fingertip_layout(), label, truth=truth)


names = st.text(st.characters(exclude_categories=["Cs"]), max_size=200)


@given(
    st.builds(
        Label,
        object=names,
        shore_a=st.none() | st.floats(0, 100),
        hardness_rank=st.none() | st.integers(0, 10),
        specimen=names,
        session=names,
        role=st.sampled_from(Role),
    )
)
def test_label_round_trips_through_json(label):
    text = json.dumps(label.to_json(), ensure_ascii=False).encode()
    assert read_record(text, Label, "label", "mend it") == label


@given(st.floats(allow_nan=False))
def test_shore_a_outside_its_scale_is_refused(shore_a):
    if 0 <= shore_a <= 100:
        assert Label(shore_a=shore_a).shore_a == shore_a
    else:
        with pytest.raises(InputError) as caught:
            Label(shore_a=shore_a)
        assert caught.value.parameter == "shore_a"


@pytest.mark.parametrize("shore_a", [-1, 428, 1e300])
def test_stored_shore_a_outside_its_scale_is_refused_by_file_and_field(shore_a):
    text = json.dumps({"object": "block", "shore_a": shore_a}).encode()
    with pytest.raises(InputError, match=r"marks\.json.*shore_a"):
        read_record(text, Label, "marks.json", "mend it")


def test_offset_is_the_time_between_the_contacts():
    rate = fingertip_layout().rate
    assert pinch(Label(), 100, 182).offset == pytest.approx(82 / rate)
    assert pinch(Label(), 100).offset is None
    assert pinch(Label()).offset is None


def test_times_of_a_slower_group_begin_with_the_pinch():
    rate = fingertip_layout().rate
    slow = Layout((Channel("p", ChannelKind.FORCE, None, "V"),), 100.0)
    layout = replace(fingertip_layout(), groups=(Group("slow", slow),))
    values = np.arange(3, dtype=np.float32)[:, None]
    data = np.zeros((900, 16), dtype=np.int16)
    groups = {"slow": Block(values, first_sample=21)}
    times, read = Pinch(data, layout, Label(), first_sample=988, groups=groups).group("slow")
    assert times == pytest.approx(np.array([0.21, 0.22, 0.23]) - 988 / rate)
    np.testing.assert_array_equal(read, values)


@pytest.fixture
def dataset():
    labels = [
        Label("block", 10.0, None, "block-10", "day 1"),
        Label("block", 60.0, None, "block-60", "day 2"),
        Label("shoebox", None, 2, "", "day 2", Role.TEST),
    ]
    return Dataset(tuple(pinch(label) for label in labels), "synthetic", ("a note",))


def test_labels_are_arrays_with_nan_for_unknown(dataset):
    assert len(dataset) == 3
    np.testing.assert_array_equal(dataset.shore_a, [10, 60, np.nan])
    np.testing.assert_array_equal(dataset.hardness_rank, [np.nan, np.nan, 2])
    assert list(dataset.objects) == ["block", "block", "shoebox"]
    assert list(dataset.specimens) == ["block-10", "block-60", ""]
    assert list(dataset.sessions) == ["day 1", "day 2", "day 2"]
    assert list(dataset.test) == [False, False, True]


def test_a_dataset_is_a_sequence_of_pinches(dataset):
    assert list(dataset) == list(dataset.pinches)
    assert dataset[0] is dataset.pinches[0]
    assert dataset[np.int64(-1)] is dataset.pinches[-1]
    assert dataset[1:].pinches == dataset.pinches[1:]
    assert dataset[[2, 0]].pinches == dataset.take([2, 0]).pinches
    assert dataset[np.array([False, True, False])].pinches == dataset.pinches[1:2]
    assert len(dataset[[]]) == 0
    assert dataset[1:].source == dataset.source


@pytest.mark.parametrize("index", [3, [3], np.array([True])])
def test_invalid_index_raises_index_error(dataset, index):
    with pytest.raises(IndexError):
        dataset[index]


@pytest.mark.parametrize("closed", [[0, 0, 3, 0], [False, False, True, True]])
def test_a_strip_closes_at_its_first_sample_that_is_not_0(closed):
    assert first_closed_sample(np.array(closed)) == 2
    assert first_closed_sample(np.array(closed), 100) == 102
    assert first_closed_sample(np.array(closed[:2]), 100) is None
    assert first_closed_sample(np.array([], np.int16)) is None


@pytest.mark.parametrize("speed", [0.0, -0.1, SLOWEST / 2, 2 * FASTEST, math.inf, math.nan])
def test_a_closing_speed_out_of_range_is_refused(speed):
    with pytest.raises(InputError) as raised:
        ClosingSpeed(speed)
    assert raised.value.parameter == "speed"
    with pytest.raises(InputError) as raised:
        ClosingSpeed(0.1, -1.0 if speed <= FASTEST else speed)
    assert raised.value.parameter == "error"
