"""Parts on ranks: the score without training, and short windows of materials left out."""

import dataclasses
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from firstcontact.core import Contact, Dataset
from firstcontact.jobs import Serial
from firstcontact.models import ESTIMATORS
from firstcontact_lab.report.findings import PartResult
from firstcontact_lab.report.results import NOTHING
from firstcontact_lab.study.part import StudySettings, Subject
from firstcontact_lab.study.parts.hardness import HARDNESS, hardness, spectral_centroid
from firstcontact_lab.study.parts.short_windows import (
    REAL,
    ShortWindows,
    materials_table,
    short_table,
    short_windows,
)

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
    correlation = order.spectral_centroid
    assert correlation.rho > 0.9
    assert correlation.n == 6
    assert correlation.exact
    assert order.classes_left_out()["svm"].n == len(ranks)
    assert order.by_session["svm"].n == len(ranks)
    left_out = order.classes_left_out()
    assert left_out
    # Materials and pinches of the three classes are as many: any constant is right for a third.
    assert all(s.best_constant == pytest.approx(1 / 3) for s in left_out.values())


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


BRIEF = StudySettings().quick()


@pytest.fixture(scope="module")
def real_set(ranks: Dataset) -> ShortWindows:
    """Return the softest and the hardest materials, with contacts that are one sample late."""
    dataset = ranks.take(ranks.hardness_rank != 1)
    late = tuple(
        p.first and Contact(p.first.finger, p.first.sample + 1, p.first.decided + 1)
        for p in dataset.pinches
    )
    subject = Subject("recordings", dataset, late, set_name="rings")
    outcome = short_windows(subject, BRIEF, Serial())
    assert short_table(outcome.results) is not None
    table = materials_table(outcome.results)
    ring_scores = outcome.results[REAL]["rings"]
    worst = ring_scores.by_material[ring_scores.worst("15")[0]]
    assert len(table.lines) == 4 + len(worst.sessions or {})
    return ring_scores


def test_every_reading_leaves_whole_materials_out(real_set: ShortWindows) -> None:
    first, labelled_contacts, smooth, published = real_set.readings
    assert ESTIMATORS[first.estimator].moves
    assert not first.conditioned
    assert (first.known_contacts, labelled_contacts.known_contacts) == (False, True)
    assert (smooth.conditioned, published.conditioned) == (True, True)
    assert published.estimator == ESTIMATORS.default
    assert real_set.material_held_out == first.material_held_out
    assert list(real_set.material_held_out) == ["3", "15"]
    assert (real_set.chance, real_set.materials) == (0.5, 4)
    assert real_set.n == sum(entry.n for entry in real_set.by_material.values())
    # Balanced: what its materials say, each once.
    for ms, share in real_set.material_held_out.items():
        materials = [entry.accuracy[ms] for entry in real_set.by_material.values()]
        assert share == pytest.approx(sum(materials) / 4)  # two materials of each rank


def test_the_worst_material_and_its_sessions_are_named(real_set: ShortWindows) -> None:
    for ms in ("3", "15"):
        name, share = real_set.worst(ms)
        assert share == real_set.by_material[name].accuracy[ms]
        for entry in real_set.by_material.values():
            assert share <= entry.accuracy[ms]
            shares = [by_length[ms] for by_length in entry.sessions.values()]
            assert min(shares) <= entry.accuracy[ms] <= max(shares)


def test_the_order_needs_no_training_and_smoothing_lowers_the_centroid(
    real_set: ShortWindows,
) -> None:
    assert real_set.rho == pytest.approx(real_set.most_rho)
    assert real_set.most_rho < 1.0  # two materials of each rank are ties
    for entry in real_set.by_material.values():
        assert entry.conditioned_centroid_hz < entry.centroid_hz


def test_ranks_of_one_material_are_left_out_with_the_reason(ranks: Dataset) -> None:
    alone = ranks.objects[ranks.hardness_rank == 0][0]
    few = ranks.take((ranks.hardness_rank > 0) | (ranks.objects == alone))
    outcome = short_windows(Subject("recordings", few), BRIEF, Serial())
    assert outcome.results is NOTHING
    assert "the ranks 0 have one material each" in outcome.left_out[0]
    outcome = short_windows(
        Subject("recordings", ranks.take(ranks.hardness_rank == 0)), BRIEF, Serial()
    )
    assert "fewer than two hardness ranks" in outcome.left_out[0]
