"""Labels, contacts, speeds, sessions and sources of imported files, and what is assumed."""

from pathlib import Path

import numpy as np
import pytest
from import_files import MAKERS, RATE, as_npz

from firstcontact import import_recordings
from firstcontact.core import ClosingSpeed, Contact, Finger, InputError, fingertip_layout
from firstcontact.recording import (
    EXPORTERS,
    Header,
    export,
    from_arrays,
    load_dataset,
    read_recording,
)
from firstcontact.signal import resample_dataset

DATA = np.random.default_rng(1).normal(size=(3, 80, 1)).astype(np.float32)
SPEEDS = [ClosingSpeed(0.12, 0.003), None, ClosingSpeed(0.2, 0.0)]
LABELS = {
    "first_contact": [40, 41, -1],
    "motor_start": [12, -1, 30],
    "closing_speed": [0.12, -1, 0.2],
    "closing_speed_error": [0.003, -1, 0],
    "shape": ["flat", "37", "-1"],
}


EACH_FORMAT = pytest.mark.parametrize("make", MAKERS)


def starts(dataset):
    return [
        -1 if p.motor_start is None else p.motor_start - p.first_sample for p in dataset.pinches
    ]


def check_labels(dataset):
    assert starts(dataset) == LABELS["motor_start"]
    assert [p.closing_speed for p in dataset] == SPEEDS
    assert [p.label.shape for p in dataset] == ["flat", "37 mm", ""]
    firsts = [-1 if p.first is None else p.first.sample - p.first_sample for p in dataset]
    assert firsts == LABELS["first_contact"]


@EACH_FORMAT
def test_labels_of_every_kind_of_file_survive_import_and_export(tmp_path, make):
    import_recordings(make(tmp_path, DATA, LABELS), tmp_path / "out")
    dataset = load_dataset(tmp_path / "out")
    check_labels(dataset)
    for to, name in (("hdf5", "y.h5"), ("csv", "y.csv")):
        export(dataset, EXPORTERS[to], tmp_path / name)
        check_labels(import_recordings(tmp_path / name, tmp_path / to))
    resampled = resample_dataset(dataset, 2 * RATE)
    assert starts(resampled) == [24, -1, 60]
    assert [p.closing_speed for p in resampled] == SPEEDS


@pytest.mark.parametrize(
    ("changes", "field"),
    [
        ({"motor_start": [40, -1, -1]}, "motor_start"),
        ({"motor_start": [-2, -1, -1]}, "motor_start"),
        ({"first_contact": [80, -1, -1]}, "first_contact"),
        ({"second_contact": [39, -1, -1]}, "second_contact"),
        ({"second_contact": [-1, -1, 30]}, "second_contact"),
        ({"pre_trigger_samples": [1, 1, 1]}, "pre_trigger_samples"),
        ({"shape": [37.0, 4.0, -1.0]}, "shape"),
        ({"closing_speed": [0.0, -1, 0.2]}, "closing_speed"),
        ({"closing_speed": [11.0, -1, 0.2]}, "closing_speed"),
        ({"closing_speed_error": [np.nan, -1, 0]}, "closing_speed_error"),
        ({"closing_speed_error": [0.003, -1, -1]}, "closing_speed_error"),
        ({"first_finger": [0.5, 0, 0]}, "first_finger"),
        ({"hardness_rank": [1, 2, 3], "hardness_class": ["soft"] * 3}, "hardness_class"),
        ({"shore_a": [101, 0, 0]}, "shore_a"),
        ({"role": ["judge"] * 3}, "role"),
        ({"session": [""] * 3}, "session"),
        ({"object": ["x" * 201] * 3}, "object"),
        ({"hardness_rank": ["1" + "0" * 300] * 3}, "hardness_rank"),
        ({"object": ["a"]}, "object"),
    ],
)
def test_labels_out_of_range_are_refused(tmp_path, changes, field):
    with pytest.raises(InputError, match=rf"x\.npz.*'{field}'"):
        import_recordings(as_npz(tmp_path, DATA, LABELS | changes), tmp_path / "out")
    assert not (tmp_path / "out").exists()


def arrays(piezo, **labels):
    given = {"piezo": piezo, "sample_rate_hz": 4936.0, "piezo_unit": "V", **labels}
    return from_arrays(Path("x"), {name: np.array(value) for name, value in given.items()})


def two_fingers(seed, finger, first, second):
    """Return noise on both channels, and a step response on each after its finger touches."""
    piezo = np.random.default_rng(seed).normal(0, 0.01, (1, 300, 2))
    # The fingers' gains differ, so the larger trace is not always the livelier one.
    piezo[..., 1] *= 20
    for touched, start in ((finger, first), (finger.other, second)):
        t = np.arange(300 - start) / 4936
        gain = 20 if touched is Finger.THUMB else 1
        piezo[0, start:, touched] += gain * np.sin(2 * np.pi * 80 * t) * np.exp(-t / 0.01)
    return piezo


@pytest.mark.parametrize("finger", Finger)
@pytest.mark.parametrize("unknown", [{}, {"first_finger": [-1]}, {"first_finger": [""]}])
def test_unknown_first_finger_is_estimated_with_a_note(finger, unknown):
    piezo = two_fingers(1, finger, 150, 180)
    dataset = arrays(piezo, first_contact=[150], second_contact=[180], **unknown)
    (pinch,) = dataset
    assert pinch.truth == (Contact(finger, 150, 150), Contact(finger.other, 180, 180))
    assert any("first_finger of 1 pinches is not known" in note for note in dataset.notes)


def test_given_first_finger_is_used_unless_there_is_one_channel():
    piezo = two_fingers(2, Finger.INDEX, 150, 180)
    both = arrays(piezo, first_contact=[150], first_finger=["thumb"])
    assert [p.truth for p in both] == [(Contact(Finger.THUMB, 150, 150),)]
    one = arrays(np.zeros((2, 60, 1)), first_contact=[20, 20], first_finger=[0, 1])
    assert [p.first and p.first.finger for p in one] == [Finger.INDEX] * 2
    assert any("one channel" in note for note in one.notes)
    assert not any("first_finger" in note for note in both.notes)
    assert arrays(piezo, first_contact=[-1]).pinches[0].truth == ()


@pytest.mark.parametrize("number", [int, float, np.int16, np.float32])
def test_whole_numbers_of_any_type_are_equal_labels(number):
    piezo = np.repeat(two_fingers(1, Finger.INDEX, 20, 40), 2, axis=0)
    dataset = arrays(
        piezo,
        specimen=[number(1), number(-20)],
        session=[number(0), number(10**4)],
        first_contact=[number(20), number(20)],
        first_finger=[number(1), number(-1)],
    )
    assert dataset.specimens.tolist() == ["1", "-20"]
    assert dataset.sessions.tolist() == ["0", "10000"]
    assert [p.first and p.first.finger for p in dataset] == [Finger.THUMB, Finger.INDEX]
    assert arrays(piezo, specimen=[1.5, 0.1]).specimens.tolist() == ["1.5", "0.1"]


@EACH_FORMAT
@pytest.mark.parametrize(
    ("stated", "option", "source"),
    [
        (None, None, "unknown"),
        (None, "real", "real"),
        ("real", None, "real"),
        ("synthetic", "synthetic", "synthetic"),
        ("unknown", "real", "real"),
    ],
)
def test_source_comes_from_the_file_or_the_option(tmp_path, make, stated, option, source):
    settings = {} if stated is None else {"source": stated}
    import_recordings(make(tmp_path, DATA, **settings), tmp_path / "o", source=option)
    dataset = load_dataset(tmp_path / "o")
    assert dataset.source == source
    assert any("source" in note for note in dataset.notes) == (source == "unknown")


@EACH_FORMAT
def test_wrong_sources_are_refused(tmp_path, make):
    path = make(tmp_path, DATA, source="real")
    with pytest.raises(InputError, match=r"real.*twin") as refused:
        import_recordings(path, tmp_path / "o", source="twin")
    assert refused.value.parameter == "source"
    (tmp_path / "other").mkdir()
    with pytest.raises(InputError, match=r"'source' .*'martian'"):
        import_recordings(make(tmp_path / "other", DATA, source="martian"), tmp_path / "o")
    assert not (tmp_path / "o").exists()


def test_assumed_sessions_are_known_from_the_header(tmp_path):
    for name, labels in (("a", {}), ("b", {"session": ["a"] * 3})):
        (tmp_path / name).mkdir()
        import_recordings(as_npz(tmp_path / name, DATA, labels), tmp_path / name / "out")
        (file,) = (tmp_path / name / "out").iterdir()
        assert read_recording(file).header.session_assumed is (name == "a")
        dataset = load_dataset(file)
        for variant in (dataset, dataset.take([0, 1]), resample_dataset(dataset, 2 * RATE)):
            assert variant.sessions_assumed is (name == "a")
    assert load_dataset(tmp_path).sessions_assumed
    assert "session_assumed" not in Header(fingertip_layout()).to_json()


def test_spellings_of_one_name_are_one_session():
    dataset = arrays(
        np.zeros((5, 60, 2)),
        session=["1", "1.0", " 01", "Day 2", "day_02"],
        specimen=["a", "b", "c", "d", "d\u00a0"],
    )
    assert list(dataset.sessions) == ["1", "1", "1", "Day 2", "day_02"]
    assert list(dataset.specimens[3:]) == ["d", "d"]
