"""Commands that read a sound input, for which PortAudio plays a recorded tape."""

from pathlib import Path

import numpy as np
import pytest

from firstcontact.cli.main import main
from firstcontact.recording import load_dataset, read_recording
from sound import local_sound

RATE = 48_000


def taps(times: list[float], seconds: float) -> np.ndarray:
    rng = np.random.default_rng(0)
    x = 30.0 * rng.standard_normal(round(seconds * RATE))
    t = np.arange(len(x)) / RATE
    for at in times:
        past = np.clip(t - at, 0, None)
        x += np.where(t >= at, 9000 * np.exp(-past / 0.004) * np.sin(2500 * past), 0.0)
    return x.astype(np.int16)


def test_record_keeps_taps_with_the_detected_contacts(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "taps"
    options = ["--object", "eraser", "--shore-a", "30", "--pinches", "2", "--out", str(out)]
    with local_sound(tmp_path, taps([2.5, 3.2, 4.0, 4.7], 8.0)):
        assert main(["record", "--device", "audio:disc", *options]) == 0
    output = capsys.readouterr().out
    assert "eraser 2/2: contact" in output
    (path,) = out.glob("*.mcap")
    recording = read_recording(path)
    assert recording.header.source == "real"
    assert [mark.found_by for mark in recording.pinches] == ["three_sigma"] * 2
    assert all(len(mark.found) == 1 and not mark.truth for mark in recording.pinches)
    apart = np.diff([mark.found[0].sample for mark in recording.pinches]) / 4936
    assert apart == pytest.approx(0.7, abs=0.12)
    # What a detector has marked is no truth for anybody that learns.
    assert all(not pinch.truth for pinch in load_dataset(out).pinches)
    assert main(["inspect", str(path)]) == 0
    assert "as three_sigma detected it, not confirmed" in capsys.readouterr().out
