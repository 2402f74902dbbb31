"""Part ``hardness``: the score without training, and the study of ranks."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from firstcontact.core import Dataset, Serial
from firstcontact_lab.report.findings import PartResult
from firstcontact_lab.report.results import NOTHING
from firstcontact_lab.study._subject import Subject
from firstcontact_lab.study.parts.hardness import HARDNESS, hardness, spectral_centroid
from firstcontact_lab.study.parts.short_windows import short_windows
from firstcontact_lab.study.settings import StudySettings

RATE = 4936.0


def tone(hertz: float, n: int = 74) -> np.ndarray:
    return np.sin(2 * np.pi * hertz * np.arange(n) / RATE).astype(np.float32)[None, :, None]


@given(st.floats(300.0, 2000.0), st.floats(0.01, 10.0))
def test_centroid_of_a_tone_is_near_its_frequency_and_blind_to_gain(
    hertz: float, gain: float
) -> None:
    computed = spectral_centroid(tone(hertz), RATE)[0]
    # The window starts at full weight, so a tone leaks: within two lines of the spectrum.
    assert computed == pytest.approx(hertz, abs=2 * RATE / 74)
    assert spectral_centroid(np.float32(gain) * tone(hertz), RATE)[0] == pytest.approx(
        computed, rel=1e-4
    )


def test_rings_that_are_faster_when_harder_come_in_order(ranks: Dataset) -> None:
    outcome = hardness(Subject("recordings", ranks), StudySettings(), Serial())
    order = outcome.results[HARDNESS]
    assert order is not None
    correlation = order.spectral_centroid
    assert correlation.rho is not None
    assert correlation.rho > 0.9
    assert correlation.n == 6
    assert correlation.exact
    assert order.classes_left_out()["svm"].n == len(ranks)
    left_out = order.classes_left_out()
    assert left_out
    # Materials and pinches of the three classes are as many: any constant is right for a third.
    assert all(s.best_constant == pytest.approx(1 / 3) for s in left_out.values())
    assert len(outcome.figures) == 2


@pytest.mark.parametrize("part", [hardness, short_windows])
def test_holds_without_a_known_contact_get_no_score(
    ranks: Dataset, part: Callable[[Subject, StudySettings, Serial], PartResult]
) -> None:
    # A detector fires somewhere in each, but nothing says that something was touched there.
    unknown = dataclasses.replace(
        ranks, pinches=tuple(dataclasses.replace(p, truth=()) for p in ranks.pinches)
    )
    subject = Subject("recordings", unknown, detections=tuple(p.first for p in ranks.pinches))
    outcome = part(subject, StudySettings(), Serial())
    assert outcome.results is NOTHING
    assert not outcome.figures
    assert "no pinch has a known first contact" in outcome.left_out[0]


def test_too_few_materials_are_left_out_with_the_reason(ranks: Dataset) -> None:
    few = ranks.take(ranks.hardness_rank == 0)
    outcome = hardness(Subject("recordings", few), StudySettings(), Serial())
    assert outcome.results is NOTHING
    assert "Hardness order" in outcome.left_out[0]
