"""Network averaged with a regression on the rig's own pinches."""

import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import firstcontact as fc
from firstcontact.core import Dataset, InputError
from firstcontact.models.labelled_data import LabelledTouches
from firstcontact.models.model_file import pretrained
from firstcontact.models.rig import combined, network_estimator
from firstcontact.models.rig.combined import CombinedEstimator, adapt_combined
from firstcontact.models.rig.network_estimator import (
    NARROWEST,
    Adapted,
    HeldOut,
    adapt_network,
    score_held_out,
)
from firstcontact.models.rig.rig_model import RigModel
from firstcontact.models.rig.rigs import Rig
from firstcontact.models.touches import Touches
from firstcontact.models.values import Values
from firstcontact.recording import load_dataset
from ringing import ringing
from trainings import recordings

pytestmark = pytest.mark.usefixtures("stored_detectors")


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    return load_dataset(recordings(tmp_path_factory.mktemp("rig") / "p"))


@pytest.fixture(scope="module")
def labelled(data: Dataset) -> LabelledTouches:
    contacts = [pinch.first for pinch in data.pinches]
    touches = LabelledTouches.cut(data, contacts)
    return touches.take(touches.touches.answerable)


@pytest.fixture(scope="module")
def adapted(labelled: LabelledTouches) -> Adapted:
    return adapt_combined(pretrained(), labelled.touches, labelled.shore_a, labelled.named_sessions)


@pytest.fixture(scope="module")
def model(adapted: Adapted) -> RigModel:
    assert adapted.model.regressions
    return adapted.model


def held_out(error: Callable[[Values], Values], levels: Sequence[float]) -> tuple[HeldOut, Values]:
    """Return errors at each scored time of four pinches of each level, and their Shore A."""
    shore_a = np.repeat(np.array(levels), 4)
    errors = error(shore_a)
    each = np.tile(errors, (len(Touches.SCORED_MS), 1))
    return HeldOut(each, errors, np.full_like(each, 3.0), np.arange(len(shore_a))), shore_a


BLOCKS = 10.0, 20.0, 29.0, 43.0, 60.0


@pytest.mark.parametrize(
    ("error", "levels", "least", "most"),
    [
        (lambda y: np.full_like(y, 4.0), BLOCKS, 2.0, 4.0),
        (lambda y: np.full_like(y, -4.0), BLOCKS, -4.0, -2.0),
        (lambda y: -0.3 * (y - 40), BLOCKS, -1e-9, 1e-9),  # drawn to the middle: no bias
        (lambda y: 8.0 * np.sign(np.sin(7 * y)), BLOCKS, -0.5, 0.5),  # no line fits
        (lambda y: np.full_like(y, 4.0), BLOCKS[:3], 0.0, 0.0),  # too few levels
    ],
)
def test_the_bias_on_own_blocks_is_subtracted_as_far_as_it_is_sure(
    error: Callable[[Values], Values], levels: Sequence[float], least: float, most: float
) -> None:
    errors, shore_a = held_out(error, levels)
    offset = errors.offset(shore_a, RigModel.rate)
    assert (offset >= least).all()
    assert (offset <= most).all()


def test_checked_errors_fall_where_all_blocks_are_biased_alike() -> None:
    errors, shore_a = held_out(lambda y: np.full_like(y, 4.0), BLOCKS)
    checked = errors.less_offset(shore_a)
    assert (checked.errors > 0).all()  # the offset is drawn to 0
    assert (checked.errors < 0.5 * errors.errors).all()
    before, after = (one.check(0.9, RigModel.rate) for one in (errors, checked))
    assert (before.coverage, after.coverage) == (0.0, 1.0)
    assert before.scales.max() > 1.3
    assert (after.scales == 1.0).all()


def test_a_blocks_own_errors_do_not_change_its_offset() -> None:
    errors, shore_a = held_out(lambda y: np.where(y == BLOCKS[0], 30.0, 0.0), BLOCKS)
    own = shore_a == BLOCKS[0]
    checked = errors.less_offset(shore_a)
    np.testing.assert_allclose(checked.errors[:, own], 30.0)
    assert (checked.errors[:, ~own] != 0.0).all()


@pytest.mark.parametrize("without", ["weight", "levels"])
def test_without_an_offset_errors_are_checked_as_they_are(
    without: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(network_estimator, "BIAS", 1e-9 if without == "weight" else 1.0)
    levels = BLOCKS if without == "weight" else BLOCKS[:3]
    errors, shore_a = held_out(lambda y: 2.0 + 0.1 * y, levels)
    checked = errors.less_offset(shore_a)
    np.testing.assert_allclose(errors.offset(shore_a, RigModel.rate), 0.0, atol=1e-9)
    np.testing.assert_allclose(checked.errors, errors.errors, atol=1e-9)


def test_the_stated_error_of_a_biased_rig_includes_its_offset(
    labelled: LabelledTouches, monkeypatch: pytest.MonkeyPatch
) -> None:
    raw = []

    def biased(*given: object) -> HeldOut:
        scored = score_held_out(*given)
        raw.append(scored.errors[-1] + 8.0)
        return replace(scored, errors=scored.errors + 8.0)

    monkeypatch.setattr(combined, "score_held_out", biased)
    made = adapt_combined(pretrained(), labelled.touches, labelled.shore_a, labelled.named_sessions)
    assert made.rmse < 0.8 * np.sqrt(np.mean(raw[0] ** 2))
    assert any("with the correction that the other blocks give" in note for note in made.notes)


def test_an_offset_shifts_predictions_and_comes_back_from_files(
    model: RigModel, labelled: LabelledTouches
) -> None:
    flat = {f: r.shifted(np.zeros(len(Rig.STAGES))) for f, r in model.regressions.items()}
    moved = {f: r.shifted(np.full(len(Rig.STAGES), 1.5)) for f, r in model.regressions.items()}
    usual, shifted = (model.with_regressions(rs, model.factors) for rs in (flat, moved))
    before, after = (m.predict_touches(labelled.touches) for m in (usual, shifted))
    inside = (before.value > 2.0) & (before.value < 99.0)
    assert inside.sum() > 20
    np.testing.assert_allclose(after.value[inside], before.value[inside] - 1.5, atol=1e-5)
    np.testing.assert_array_equal(after.spread, before.spread)
    arrays = shifted.to_arrays()
    for kept in (arrays, {k: v for k, v in arrays.items() if not k.endswith(".offset")}):
        read = RigModel.from_arrays(kept, shifted.level).predict_touches(labelled.touches)
        expected = after if kept is arrays else before
        np.testing.assert_allclose(read.value, expected.value, atol=1e-5)


def test_far_from_the_rigs_pinches_the_network_counts_more(
    model: RigModel, labelled: LabelledTouches
) -> None:
    _, near = model.regress(labelled.touches)
    strange = replace(labelled.touches, signals=-30 * labelled.touches.signals[:, ::-1])
    _, far = model.regress(strange)
    assert far.min() > np.median(near)


def test_a_folder_holds_both(data: Dataset, tmp_path: Path) -> None:
    trained = fc.train(data, "combined")
    assert trained.network.name == "combined"
    read = fc.load_model(trained.save(tmp_path / "m"))
    np.testing.assert_allclose(read.predict(data).value, trained.predict(data).value, atol=1e-3)
    np.testing.assert_allclose(read.network.factors, trained.network.factors, rtol=1e-6)
    notes = [note for note in trained.notes if note.startswith("combined, on the same pinches")]
    scores = trained.network.record.scores
    stated = re.search(r"rmse ([\d.]+)", notes[0])
    # The card has three decimals, the sentence two.
    assert float(stated[1]) == pytest.approx(scores["held out, combined"], abs=0.0056)
    assert "held out, network" in scores


def test_the_network_can_be_taken_out_of_the_model(data: Dataset) -> None:
    adapted = fc.adapt(data)
    alone = adapted.only("network").network
    assert (adapted.network.name, alone.name) == ("combined", "network")
    expected = fc.train(data, "network").predict(data)
    predictions = adapted.predict(data, estimator="network")
    np.testing.assert_array_equal(predictions.value, expected.value)
    np.testing.assert_array_equal(predictions.low, expected.low)
    with pytest.raises(InputError) as refused:
        adapted.only("svm")
    assert refused.value.parameter == "estimator"


def test_the_network_alone_keeps_the_widths_of_its_own_intervals(labelled: LabelledTouches) -> None:
    narrow = pretrained().rescaled(np.full(len(Rig.STAGES), 0.2))
    given = labelled.touches, labelled.shore_a, labelled.named_sessions
    network, average = adapt_network(narrow, *given).model, adapt_combined(narrow, *given).model
    assert average.regressions
    restored = RigModel.from_arrays(average.to_arrays(), average.level)
    assert not np.allclose(network.factors, average.factors)
    for made in (average, restored):
        np.testing.assert_allclose(made.network_alone().factors, network.factors, rtol=1e-6)
        np.testing.assert_allclose(made.factors, average.factors, rtol=1e-6)


def test_the_mixture_and_the_network_must_both_be_of_use(adapted: Adapted) -> None:
    assert not adapted.why_useless
    for name in ("combined", "network"):
        worse = {**adapted.scores, name: adapted.mean_rmse + 1}
        assert replace(adapted, scores=worse).why_useless


def test_a_network_that_scored_better_is_named(
    data: Dataset, adapted: Adapted, monkeypatch: pytest.MonkeyPatch
) -> None:
    scores = {**adapted.scores, "combined": adapted.mean_rmse - 0.01, "network": 0.01}
    made = replace(adapted, scores=scores)
    monkeypatch.setattr(CombinedEstimator, "adapt", staticmethod(lambda *_: made))
    assert any(
        "the network alone had a lower error" in note for note in fc.train(data, "combined").notes
    )


def test_a_pinch_without_a_first_swing_changes_other_predictions_little(
    labelled: LabelledTouches, model: RigModel
) -> None:
    touches = labelled.touches
    signals = touches.signals.copy()
    signals[0, touches.lead :] = -np.abs(signals[0, touches.lead :])
    made = adapt_combined(
        pretrained(), replace(touches, signals=signals), labelled.shore_a, labelled.named_sessions
    ).model
    moved = made.predict_touches(touches).value - model.predict_touches(touches).value
    assert np.abs(moved[1:]).mean() < 1.0


def test_too_few_pinches_are_noted(data: Dataset) -> None:
    few = data[:18]
    trained = fc.train(few, "combined")
    assert trained.network.name == "network"
    assert (
        "the network predicts alone, because there are fewer than 20 pinches or 3 values of Shore A"
        in trained.notes
    )
    assert not any("predicts alone" in note for note in fc.train(few, "network").notes)


def test_a_rig_of_three_levels_has_no_offset_and_no_note_of_one() -> None:
    made = adapt_combined(pretrained(), *ringing(60, levels=(10.0, 40.0, 90.0)))
    assert made.model.regressions
    assert not made.notes


def test_intervals_of_a_rig_with_small_errors_on_blocks_become_narrower_up_to_a_limit(
    labelled: LabelledTouches,
) -> None:
    """Blocks alone would allow intervals of almost no width."""
    wide = pretrained()
    wide = RigModel(
        wide.network, wide.familiar, wide.factors, wide.level, wide.rigs, 50 * wide.mixed
    )
    made = adapt_combined(wide, labelled.touches, labelled.shore_a, labelled.named_sessions)
    np.testing.assert_allclose(made.check.scales, NARROWEST, rtol=0.02)
    np.testing.assert_array_equal(made.model.factors, wide.mixed * made.check.scales)
