import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firstcontact.core import Calibration, Finger, ForceCurve, InputError, VibrationCalibration
from firstcontact.core.calibration import read_calibration, write_calibration

positive = st.floats(1e-9, 1e3)
piezos = st.builds(
    VibrationCalibration, st.sampled_from(Finger), positive, st.floats(-1, 1), st.none() | positive
)
curves = st.builds(
    ForceCurve, st.sampled_from(Finger), positive, positive, positive, positive, positive
)


def of_fingers(records):
    """Return lists with at most one record of each finger."""
    return st.lists(records, max_size=2, unique_by=lambda record: record.finger)


@given(of_fingers(piezos), of_fingers(curves))
def test_calibration_round_trips_through_its_file(tmp_path_factory, piezo, force):
    path = tmp_path_factory.mktemp("calibration") / "Größe.json"
    calibration = Calibration(tuple(piezo), tuple(force), "2026-01-01T00:00:00+00:00")
    write_calibration(calibration, path)
    assert read_calibration(path) == calibration


CURVE = {"finger": 1, "leak": 0.0, "gain": 0.0, "exponent": 1.0, "rms": 0.0}


def tree(**change):
    piezo = {"finger": 0, "noise": 0.002, "offset": 0.0, "tap": None}
    head = {"format": "firstcontact.calibration", "version": 1}
    return {**head, "piezo": [piezo], "force": [], "created": "", **change}


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        ("{", "calibration.json"),
        ("[1]", "calibration.json"),
        (json.dumps(tree(format="other")), "format"),
        (json.dumps(tree(version=2)), "version"),
        (json.dumps(tree(piezo=[{"finger": 0}])), "noise"),
        (json.dumps(tree(piezo=[{"finger": 7, "noise": 1.0}])), "finger"),
        (json.dumps(tree(piezo=[{"finger": 0, "noise": -1.0}])), "noise"),
        (json.dumps(tree(piezo=[{"finger": 0, "noise": 0.0}])), "noise"),
        ('{"a":' * 100_000, "calibration.json"),
        (json.dumps(tree()).replace("0.002", "9" * 400), "noise"),
        (json.dumps(tree(piezo=[{"finger": 1, "noise": "loud"}])), "noise"),
        (json.dumps(tree(force=[CURVE])), "gain"),
    ],
)
def test_invalid_calibration_files_are_refused(tmp_path, content, problem):
    path = tmp_path / "calibration.json"
    path.write_text(content)
    with pytest.raises(InputError, match=problem) as error:
        read_calibration(path)
    assert str(path) in str(error.value)
    assert "firstcontact calibrate" in str(error.value)


def test_inaccessible_calibration_files_are_refused(tmp_path):
    with pytest.raises(InputError, match=r"none\.json"):
        read_calibration(tmp_path / "none.json")
    with pytest.raises(InputError, match=tmp_path.name):
        write_calibration(Calibration(), tmp_path)
