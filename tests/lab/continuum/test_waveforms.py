"""Files of touches that others computed."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from firstcontact.core import FileError
from firstcontact_lab.continuum.bodies import Material, sphere
from firstcontact_lab.continuum.comparison import twin_touch
from firstcontact_lab.continuum.touch import touch
from firstcontact_lab.continuum.waveforms import MOST_BYTES, compare_file, parse_touch_name

TIMES = np.arange(0.0, 0.0165, 1e-5)
NAME = "block-29-rigid-sls-small"


def written(path: Path, **arrays: Any) -> Path:
    np.savez(path / "touches.npz", **arrays)
    return path / "touches.npz"


@pytest.mark.parametrize(
    "name",
    [
        NAME,
        "wide-29-rigid-elastic-small",
        "avocado-63-pad-sls-large",
        "tennis-45-dimples-sls-stick",
    ],
)
def test_a_louder_touch_is_so_much_louder(tmp_path: Path, name: str) -> None:
    finger, target = parse_touch_name("test", name)
    volts = twin_touch(target, finger, TIMES)
    path = written(tmp_path, **{f"{name}/t": TIMES, f"{name}/volts": 1.25 * volts})
    found = compare_file(path)[name]
    assert found.peak == pytest.approx(-0.2, abs=1e-6)
    assert found.rms == pytest.approx(0.2, abs=1e-6)
    assert found.rms_of_peak < found.rms


def test_names_mean_the_objects_that_they_say(tmp_path: Path) -> None:
    name = "sphere-60-rigid-sls-small"
    finger, target = parse_touch_name("test", name)
    ball = 4 / 3 * np.pi * 0.037**3
    arms = ((target.arm_share, target.arm_relaxation),)
    found = touch(finger, sphere(0.037, Material(0.18 / ball, 3.61e6, arms)))
    path = written(tmp_path, **{f"{name}/t": found.times, f"{name}/volts": found.volts})
    comparison = compare_file(path)[name]
    assert abs(comparison.peak) < 0.05
    assert comparison.rms_of_peak < 0.05
    assert parse_touch_name("test", "sphere-60-rigid-elastic-small")[1].arm_share == 0
    wide, block = (parse_touch_name("test", f"{s}-29-pad-sls-small")[1] for s in ("wide", "block"))
    assert wide.face_mass == pytest.approx(4 * block.face_mass)


@pytest.mark.parametrize(
    "arrays",
    [
        {},
        {"t": TIMES, "volts": TIMES},
        {f"{NAME}/t": TIMES},
        {f"{NAME}/t": TIMES, f"{NAME}/volts": TIMES[1:]},
        {f"{NAME}/t": TIMES[::-1], f"{NAME}/volts": TIMES},
        {f"{NAME}/t": TIMES * 10, f"{NAME}/volts": TIMES},
        {f"{NAME}/t": TIMES, f"{NAME}/volts": np.full(TIMES.size, np.nan)},
        {f"{NAME}/t": TIMES, f"{NAME}/volts": np.array([None, 1.0])},
        {f"{NAME}/t": TIMES, f"{NAME}/volts": np.array(["loud"])},
        *(
            {f"{name}/t": TIMES, f"{name}/volts": TIMES}
            for name in ("block", "block-0-rigid-sls-small", "cube-9-rigid-sls-small")
        ),
        {"block-9-finger-sls-small/t": TIMES, "block-9-finger-sls-small/volts": TIMES},
    ],
)
def test_other_files_are_refused(tmp_path: Path, arrays: dict[str, Any]) -> None:
    path = written(tmp_path, **arrays)
    with pytest.raises(FileError, match=str(path)):
        compare_file(path)


def test_a_file_that_is_no_archive_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "touches.npz"
    path.write_text("t,volts\n", encoding="utf-8")
    for name in (path, tmp_path / "none.npz", tmp_path):
        with pytest.raises(FileError, match=str(name)):
            compare_file(name)


def test_a_small_file_that_unpacks_to_a_large_one_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "touches.npz"
    large = np.zeros(MOST_BYTES // 8)
    np.savez_compressed(path, **{f"{NAME}/t": large})
    with pytest.raises(FileError, match="bytes unpacked"):
        compare_file(path)
