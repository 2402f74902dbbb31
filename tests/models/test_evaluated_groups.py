"""Groups of evaluated pinches, and the scores over all of them that were not in the training."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

import firstcontact as fc
from firstcontact.core import Role
from firstcontact.models._evaluate import overlap_groups
from firstcontact.models.evaluation import Overlap

pytestmark = pytest.mark.usefixtures("small_searches")

NEW = "not seen in training"
OTHER_SESSIONS = "specimens of the training, other sessions"


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> fc.Dataset:
    folder = tmp_path_factory.mktemp("evaluate") / "pinches"
    return fc.simulate(folder, pinches_per_block=6, pinches_per_object=1, seed=1)


@pytest.fixture(scope="module")
def blocks(data: fc.Dataset) -> fc.Dataset:
    """Pinches of five blocks."""
    return data[~data.test]


@pytest.fixture(scope="module")
def objects(data: fc.Dataset) -> fc.Dataset:
    """One pinch of each of eight objects of other shapes, with role "train"."""
    return relabelled(data[data.test], lambda label: replace(label, role=Role.TRAIN, session="z"))


def relabelled(data: fc.Dataset, change: Callable[[fc.Label], fc.Label]) -> fc.Dataset:
    pinches = tuple(replace(pinch, label=change(pinch.label)) for pinch in data)
    return replace(data, pinches=pinches)


def together(*parts: fc.Dataset) -> fc.Dataset:
    return replace(parts[0], pinches=tuple(pinch for part in parts for pinch in part))


def numbered(data: fc.Dataset) -> fc.Dataset:
    """Name all specimens "1", as people do who number the specimens of each object."""
    return relabelled(data, lambda label: replace(label, specimen="1"))


def fresh(data: fc.Dataset, session: str) -> fc.Dataset:
    """Return pinches of another session with other samples."""
    pinches = tuple(
        replace(p, data=p.data + 1, label=replace(p.label, session=session)) for p in data
    )
    return replace(data, pinches=pinches)


def sizes(model: fc.Model, data: fc.Dataset) -> dict[str, int]:
    groups = overlap_groups(data, model.trained_on, model.digests)
    return {title: int(members.sum()) for title, members in groups.items() if members.any()}


def mean(values: NDArray[np.float64]) -> float:
    return float(values.mean())


def test_scores_cover_all_pinches_that_were_not_in_the_training(
    blocks: fc.Dataset, objects: fc.Dataset
) -> None:
    model = fc.adapt(blocks[::2])
    data = together(blocks, fresh(blocks[1::2], "y"), objects[:1])
    (evaluation,) = fc.evaluate(model, data, contacts="known")
    assert len(evaluation.groups) == 4
    assert evaluation.groups[0].n == 1
    is_new = np.arange(len(data)) >= len(blocks)  # those before have sessions of the training
    for at, rmse in evaluation.rmse.items():
        predictions = model.predict(data, at, contacts="known").take(is_new)
        truth = data.shore_a[is_new]
        scored = np.isfinite(predictions.value)
        error = (predictions.value - truth)[scored]
        held = ((predictions.low <= truth) & (truth <= predictions.high))[scored]
        assert rmse == pytest.approx(np.sqrt(mean(error**2)))
        assert evaluation.coverage[at] == pytest.approx(mean(held))
        width = mean((predictions.high - predictions.low)[scored])
        assert evaluation.width[at] == pytest.approx(width)
    (namesakes,) = fc.evaluate(model, blocks, contacts="known")
    assert [group.title for group in namesakes.groups] == [Overlap.NAMESAKES, Overlap.SEEN]
    assert namesakes.rmse == namesakes.groups[0].rmse
    (alone,) = fc.evaluate(model, objects, contacts="known")
    assert alone.rmse == alone.groups[0].rmse
    (training,) = fc.evaluate(model, blocks[::2], contacts="known")
    assert [group.title for group in training.groups] == [Overlap.SEEN]
    assert training.rmse == training.coverage == training.width == {}


def test_known_contacts_are_warned_of_if_the_model_learned_from_detected_ones(
    blocks: fc.Dataset, objects: fc.Dataset
) -> None:
    model = fc.adapt(blocks)
    scores = {
        contacts: fc.evaluate(model, objects, contacts=contacts)[0]
        for contacts in ("known", "detected")
    }
    added = set(scores["known"].warnings) - set(scores["detected"].warnings)
    assert len([warning for warning in added if "detected contacts" in warning]) == 1
    learned = fc.train(blocks, "network", contacts="known")
    assert not any(
        "detected contacts" in warning
        for warning in fc.evaluate(learned, objects, contacts="known")[0].warnings
    )


def test_objects_that_share_a_specimen_name_are_scored_apart(objects: fc.Dataset) -> None:
    model = fc.adapt()
    named = fc.evaluate(model, objects, contacts="known")[0].groups[0]
    shared = fc.evaluate(model, numbered(objects), contacts="known")[0].groups[0]
    assert len(shared.objects) == len(named.objects) == named.n > 1
    assert {errors.object: errors for errors in shared.objects.values()} == {
        errors.object: errors for errors in named.objects.values()
    }


def test_an_unseen_object_with_the_name_of_a_seen_specimen_is_new(
    blocks: fc.Dataset, objects: fc.Dataset
) -> None:
    model = fc.adapt(numbered(blocks))
    assert sizes(model, numbered(objects)) == {NEW: len(objects)}
    assert sizes(model, numbered(fresh(blocks, "y"))) == {OTHER_SESSIONS: len(blocks)}
    one_block = blocks[blocks.shore_a == blocks.shore_a[0]]
    assert sizes(model, numbered(fresh(one_block, "y"))) == {OTHER_SESSIONS: len(one_block)}


def test_unnamed_sessions_and_specimens_are_never_the_same(blocks: fc.Dataset) -> None:
    unnamed = relabelled(blocks, lambda label: replace(label, specimen="", session=""))
    model = fc.adapt(unnamed)
    assert sizes(model, unnamed) == {Overlap.SEEN: len(blocks)}
    assert sizes(model, fresh(unnamed, "")) == {NEW: len(blocks)}


def test_long_names_can_be_saved(
    blocks: fc.Dataset, tmp_path_factory: pytest.TempPathFactory
) -> None:
    long = relabelled(
        blocks, lambda label: replace(label, specimen="s" * 200, object=f"{label.shore_a}" * 40)
    )
    folder = fc.adapt(long).save(tmp_path_factory.mktemp("long") / "rig")
    loaded = fc.load_model(folder)
    assert sizes(loaded, fresh(long, "y")) == {OTHER_SESSIONS: len(blocks)}
