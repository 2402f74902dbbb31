"""Self-test of fingertips: faults put into the simulated circuit are found, and named."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import write_check as script

from firstcontact import InputError
from firstcontact.cli.main import main
from firstcontact.collect._self_test import array_faults
from firstcontact.collect.check import check_fingertips
from firstcontact.twin.faults import FAULTS

#: Random hands of a fault; `docs/write_check.py` measures more.
FEW = range(5000, 5002)


@pytest.mark.parametrize("fault", ["", *FAULTS])
def test_a_fault_of_the_circuit_is_found(fault: str) -> None:
    found = (script.test_hand(fault, seed) for seed in FEW)  # one by one, until it is found
    # A few percent of the faults are too small to be found.
    assert any(script.CHECKS[fault][1] in names for names in found) if fault else not any(found)


@pytest.mark.parametrize(
    ("factor", "is_good"), [(0.97, True), (1.5, True), (-0.9, False), (0.1, False), (6.0, False)]
)
def test_corners_must_answer_as_the_middle(factor: float, is_good: bool) -> None:
    source = script.BenchSource("paper-rig", 5000)
    source.bench.bench = replace(source.bench.bench, corners=np.full(2, factor))
    _, verdicts = check_fingertips(source, drift=0)
    assert [v.is_good for v in verdicts if v.check == "places"] == [is_good] * 2


def test_rows_and_columns_are_named() -> None:
    one_by_one = np.repeat(np.eye(6), 3, axis=0)
    assert array_faults(one_by_one) == []
    assert array_faults(one_by_one * [1, 1, 0, 0, 1, 1]) == ["row 1 is open"]
    assert array_faults(one_by_one * [0, 1, 0, 1, 0, 1]) == ["column 0 is open"]
    assert array_faults(one_by_one * [1, 1, 1, 0, 1, 1]) == ["taxel 3 does not rise"]
    rows = one_by_one[:, [0, 1, 2, 3, 0, 1]] + one_by_one[:, [4, 5, 2, 3, 4, 5]]
    assert array_faults(rows) == ["rows 0 and 2 are connected"]
    assert array_faults(0 * rows) == ["no taxel rises"]


def test_the_command_writes_one_page_without_links(tmp_path, capsys) -> None:
    out = tmp_path / "check.html"
    options = ["--speed", "20", "--drift", "0", "--fault", "polarity", "--out", str(out)]
    assert main(["check", "--device", "twin", *options]) == 1
    printed = capsys.readouterr().out
    assert "polarity" in printed
    assert "jitter is not measured" in printed
    assert "`calibrate` measures another pair" in printed
    page = out.read_text()
    assert "The disc lies on its wrong face" in page
    assert "<svg" in page
    assert "http" not in page
    assert [path.name for path in tmp_path.iterdir()] == ["check.html"]


@pytest.mark.parametrize(
    ("options", "text"),
    [
        (["--fault", "smell"], "the fault 'smell' is not known"),
        (["--drift", "3", "--speed", "20"], "--drift: "),
        (["--device", "/dev/null", "--fault", "hum"], "--fault: "),
    ],
)
def test_unusable_options_are_refused(tmp_path, capsys, options, text) -> None:
    out = tmp_path / "check.html"
    assert main(["check", "--device", "twin", "--out", str(out), *options]) == 2
    assert text in capsys.readouterr().err
    assert not out.exists()


def test_a_disc_on_a_sound_card_has_no_fingers() -> None:
    source = script.BenchSource("paper-rig", 0)
    layout = source.descriptor.layout
    channels = (replace(layout.channels[0], finger=None),)
    source.descriptor = replace(source.descriptor, layout=replace(layout, channels=channels))
    with pytest.raises(InputError, match="no fingertips"):
        check_fingertips(source)


def test_all_faults_are_measured_and_misses_are_marked() -> None:
    rows = json.loads(Path(script.RESULTS).read_text("utf-8"))["faults"]
    assert set(rows) == {"", *FAULTS}
    assert rows[""]["found"] <= script.FALSE * rows[""]["hands"]
    missed = [n for n, r in rows.items() if n and r["found"] < script.FOUND * r["hands"]]
    assert script.PAGE.read_text("utf-8").count("misses the goal") == len(missed)


def test_taps_that_fade_into_the_noise_have_no_decay_of_zero() -> None:
    verdicts = [
        check_fingertips(script.BenchSource("paper-rig", n), drift=0)[1] for n in (101, 103)
    ]
    measured = [v.measured for hand in verdicts for v in hand if v.check == "rattle"]
    assert "taps fade into the noise" in measured
    assert not any(words.startswith("0.0") for words in measured)
