"""Pinches and datasets: labels, offsets, selection."""

import json
import math
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from firstcontact.core import (
    Block,
    Calibration,
    Channel,
    ChannelKind,
    ClosingSpeed,
    Contact,
    Dataset,
    Finger,
    ForceCurve,
    Group,
    InputError,
    Label,
    Layout,
    Pinch,
    Role,
    VibrationCalibration,
    fingertip_layout,
)
from firstcontact.core.pinch import FASTEST, SLOWEST, first_closed_sample
from firstcontact.core.records import read_record


def pinch(label, *samples):
    truth = tuple(Contact(Finger(i % 2), s, s) for i, s in enumerate(samples))
    return Pinch(np.zeros((200, 16), dtype=np.int16), fingertip_layout(), label, truth=truth)


names = st.text(st.characters(exclude_categories=["Cs"]), max_size=60)


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


@pytest.mark.parametrize("role", [Role.TEST, "test", "TEST "])
def test_role_given_as_text_is_a_role(role):
    made = Label(role=role)
    assert made.role is Role.TEST
    assert list(Dataset((pinch(made), pinch(Label(role="train")))).test) == [True, False]


#: Spellings of one name, which must be one session or specimen.
SPELLINGS = [
    [1, 1.0, np.int64(1), "1", "1.0", " 1", "1\u00a0", "01", "\uff11"],
    ["Äpfel 2", "A\u0308pfel 2", "Äpfel  2\n", "\ufeffÄpfel\u00a02", np.str_("Äpfel 2")],
    ["", None, math.nan, np.float32("nan"), np.datetime64("NaT"), "nan", " "],
]


@pytest.mark.parametrize("spellings", SPELLINGS)
@pytest.mark.parametrize("field", ["object", "specimen", "session"])
def test_spellings_of_one_name_are_one_name(field, spellings):
    assert len({getattr(Label(**{field: name}), field) for name in spellings}) == 1


def test_shape_given_as_a_number_is_text():
    assert (Label(shape=12.0).shape, Label(shape=math.nan).shape) == ("12", "")


replaced = partial(replace, pinch(Label()))
WRONG = [
    ("session", b"day", Label),
    ("specimen", "x" * 201, Label),
    ("role", "exam", Label),
    ("shore_a", "60", Label),
    ("shore_a", 10**400, Label),
    ("hardness_rank", 10**5000, Label),
    ("hardness_rank", 2.5, Label),
    ("sample", math.nan, partial(Contact, None)),
    ("finger", 7, partial(Contact, sample=3)),
    ("speed", 10**400, ClosingSpeed),
    ("noise", 0, partial(VibrationCalibration, None)),
    ("noise", math.nan, partial(VibrationCalibration, None)),
    ("gain", 0.0, partial(ForceCurve, Finger.INDEX, 0.0, exponent=1.0, rms=0.0)),
    ("piezo", (VibrationCalibration(None, 1.0),) * 2, Calibration),
    ("data", np.zeros(200), replaced),
    ("data", np.zeros((16, 200)), replaced),
    ("data", np.full((200, 16), "1"), replaced),
    ("label", "block", replaced),
    ("calibration", 0.002, replaced),
    ("closing_speed", 0.1, replaced),
    ("truth", [Contact(Finger.INDEX, 200)], replaced),
    ("truth", [Contact(Finger.INDEX, -1)], replaced),
    ("truth", [Contact(Finger.INDEX, 5), Contact(Finger.INDEX, 9)], replaced),
    ("truth", [Contact(Finger.INDEX, 9), Contact(Finger.THUMB, 5)], replaced),
    ("motor_start", 201, replaced),
    ("first_sample", 0.5, replaced),
]


@pytest.mark.parametrize(("field", "value", "make"), WRONG, ids=range(len(WRONG)))
def test_values_that_cannot_be_are_refused_where_they_are_given(field, value, make):
    with pytest.raises(InputError) as caught:
        make(**{field: value})
    assert caught.value.parameter == field
    assert len(str(caught.value)) < 250


def test_two_channels_of_one_finger_are_refused():
    thumb, index = fingertip_layout().channels[1], fingertip_layout().channels[0]
    twice = Layout((index, replace(thumb, finger=Finger.INDEX)), 4936.0)
    with pytest.raises(InputError) as caught:
        Pinch(np.zeros((10, 2)), twice)
    assert caught.value.parameter == "layout"
    as_numbers = Layout((Channel("a", "vibration", 0, "V"), Channel("b", "piezo", 1, "V")), 4936.0)
    assert as_numbers.vibration_fingers == tuple(Finger)


def test_masked_samples_are_missing_not_numbers():
    data = np.ma.masked_array(np.ones((3, 16), np.int16), mask=False)
    assert type(Pinch(data, fingertip_layout()).data) is np.ndarray
    data[1, 4] = np.ma.masked
    assert np.argwhere(np.isnan(Pinch(data, fingertip_layout()).data)).tolist() == [[1, 4]]


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
