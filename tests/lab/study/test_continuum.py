"""Part of the study that compares touches of the twin with finite elements."""

from pathlib import Path

import numpy as np
import pytest

from firstcontact.core import Dataset
from firstcontact.jobs import Serial
from firstcontact_lab.study.part import StudySettings, Subject
from firstcontact_lab.study.parts.continuum import (
    CONTINUUM,
    DIMPLES,
    PART,
    continuum,
    fits,
    loss_biases,
)


def test_power_and_line_of_peaks_are_those_of_a_curve() -> None:
    levels = (10, 20, 29, 43, 60)
    power, line = fits({f"block {s}": 0.2 * s**0.5 for s in levels} | {"apple 1": 9.0})
    assert power == pytest.approx(0.5)
    assert line < 1
    power, line = fits({f"block {s}": 0.2 + 0.01 * s for s in levels})
    assert power < 0.6
    assert line == pytest.approx(1.0)


def test_part_shows_each_touch_and_the_claim(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr("firstcontact_lab.study.parts.continuum.BRIEF", ("block 10", "block 20"))
    subject = Subject("paper-rig", Dataset((), "twin"))
    names = ("block-29-rigid-sls-small", "wide-29-pad-sls-small", "block-60-rigid-sls-large")
    path = tmp_path / "touches.npz"
    np.savez(path, **{f"{n}/{key}": [0.0, 0.002] for n in names for key in ("t", "volts")})
    result = continuum(subject, StudySettings(brief=True, waveforms=str(path)), Serial())
    found = result.results[CONTINUUM]
    scores = found.tips[DIMPLES]["block 20"]
    assert scores.peak == pytest.approx(scores.twin / scores.elements - 1)
    assert np.sign(scores.rms) > 0
    assert [figure.key for figure in result.figures] == ["pad-on-dimples", "rigid-tip"]
    tables = PART.made_tables(result.results)
    assert [len(table.lines) for table in tables] == [2, 2, 3, 3, 2, 3]
    assert [line.cells[1].text for line in tables[4].lines] == ["2", "1"]
    other = continuum(Subject("everyday", Dataset((), "twin")), StudySettings(), Serial())
    assert other.results[CONTINUUM] is None


def test_loss_reads_an_object_harder() -> None:
    biases = loss_biases(("orange 1", "block 29"))
    assert biases["orange 1"].none < biases["orange 1"].fast < biases["orange 1"].both
    assert biases["block 29"].fast == biases["block 29"].both == pytest.approx(0, abs=0.5)
