import json

import pytest

from firstcontact.cli.main import main
from firstcontact.core import Finger
from firstcontact.core.calibration import read_calibration

WEIGHTS = "finger,newtons,volts\n" + "".join(
    f"{finger},{n},{v}\n"
    for finger in ("index", "thumb")
    for n, v in ((0, 0.3), (0.5, 0.9), (1, 1.2), (2, 1.6), (5, 2.2))
)


def test_the_twin_is_calibrated_between_its_closings(tmp_path, capsys):
    weights = tmp_path / "weights.csv"
    weights.write_text(WEIGHTS)
    out = tmp_path / "calibration.json"
    arguments = ["--no-tap", "--seconds", "0.5", "--patience", "30", "--weights", str(weights)]
    assert main(["calibrate", "--device", "twin", "--out", str(out), *arguments]) == 0
    calibration = read_calibration(out)
    output = capsys.readouterr().out
    for finger in Finger:
        assert 0.001 < calibration.noise(finger) < 0.003
        assert f"{finger.name.lower()}  noise" in output
    assert [c.finger for c in calibration.force] == list(Finger)
    assert all(c.rms < 0.3 for c in calibration.force)
    assert json.loads(out.read_text())["format"] == "firstcontact.calibration"


def test_what_the_fingertips_feel_is_their_tap(tmp_path, capsys):
    # Nobody taps the simulated hand, but it closes: its contacts are taken for taps.
    out = tmp_path / "calibration.json"
    assert main(["calibrate", "--device", "twin", "--out", str(out), "--seconds", "0.3"]) == 0
    assert all(p.tap > 0.02 for p in read_calibration(out).piezo)
    assert "tap the fingertip of the index finger" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        (["--seconds", "0"], "--seconds: "),
        (["--weights", "none.csv"], "none.csv cannot be read"),
        (["--weights", "none.csv", "--weigh", "0", "1", "2", "5"], "--weigh: "),
    ],
)
def test_what_cannot_be_calibrated_is_refused(tmp_path, capsys, arguments, text):
    out = tmp_path / "calibration.json"
    assert main(["calibrate", "--device", "twin", "--out", str(out), *arguments]) == 2
    assert text in capsys.readouterr().err
    assert not out.exists()


def test_an_unwritable_result_is_told_before_the_work(tmp_path, capsys):
    (tmp_path / "file").write_text("as it was")
    for out in (tmp_path, tmp_path / "file" / "calibration.json"):
        assert main(["calibrate", "--device", "twin", "--out", str(out)]) == 2
        captured = capsys.readouterr()
        assert f"{out} cannot be written" in captured.err
        assert "Traceback" not in captured.err
        assert captured.out == ""  # nothing was asked for
    assert [p.name for p in tmp_path.iterdir()] == ["file"]
    assert (tmp_path / "file").read_text() == "as it was"
