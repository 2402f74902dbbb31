"""Pre-training: one seed gives the same weights for any workers, also after a stop."""

from __future__ import annotations

from dataclasses import fields
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from firstcontact.chain import INPUTS
from firstcontact.core import Serial, parallel
from firstcontact.models import LEVELS, STAGES, TOKEN
from firstcontact_lab.pretraining import _examples, _sets
from firstcontact_lab.pretraining._batches import draw_batch, token_rows
from firstcontact_lab.pretraining._examples import (
    ASKED,
    CONTEXTS,
    Examples,
    joined,
    rig_examples,
)
from firstcontact_lab.pretraining._finishing import LEVEL, answers, finished
from firstcontact_lab.pretraining._sets import example_set
from firstcontact_lab.rigs import FAMILIES

if TYPE_CHECKING:
    from firstcontact_lab.pretraining._training import Full, Training

pytestmark = pytest.mark.skipif(find_spec("torch") is None, reason="PyTorch is not installed")
SEED = 5


def training(*arguments: Any) -> Training:
    """Start a training. Only the process that runs it imports PyTorch."""
    from firstcontact_lab.pretraining._training import Training

    return Training(*arguments)


@pytest.fixture(autouse=True)
def _small_rigs(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Pinch few objects and blocks on each rig, except where other processes pinch the rigs."""
    if "whatever_the_workers" not in request.node.name:
        monkeypatch.setattr(_examples, "THINGS", 8)
        monkeypatch.setattr(_examples, "CONTEXT", (4, 6))


@cache
def few() -> Examples:
    return joined([rig_examples(number, SEED) for number in range(4)])


def same(one: Examples, other: Examples) -> bool:
    return all(
        np.array_equal(getattr(one, f.name), getattr(other, f.name), equal_nan=True)
        for f in fields(Examples)
    )


def weights(full: Full) -> np.ndarray:
    tensors = full.network.state_dict().values()
    return np.concatenate([np.ravel(a) for a in (*tensors, *full.scales.values())])


def test_a_rig_depends_on_its_number_and_the_seed_alone() -> None:
    assert same(rig_examples(2, SEED), rig_examples(2, SEED))
    assert not np.array_equal(rig_examples(2, SEED).signals, rig_examples(2, SEED + 1).signals)
    assert not np.array_equal(rig_examples(2, SEED).signals, rig_examples(3, SEED).signals)


def test_shapes_fit_and_numbers_are_finite() -> None:
    examples = few()
    n = len(examples)
    assert set(np.unique(examples.rigs)) == {0, 1, 2, 3}
    for rig in range(4):
        entry = examples.object_ids[examples.rigs == rig]
        assert sorted(set(entry)) == list(range(-1, _examples.THINGS))
        assert (entry >= 0).sum() == _examples.THINGS * ASKED
    assert examples.tokens.shape == (4, CONTEXTS, len(STAGES), LEVELS, TOKEN)
    assert ((examples.levels >= 2) & (examples.levels <= LEVELS)).all()
    for f in fields(Examples):
        assert np.isfinite(getattr(examples, f.name)).all() or f.name == "radii"
    assert examples.shore_a.shape == (n,)
    assert (examples.scale[..., 0] > 0).all()
    assert set(np.unique(examples.scale[..., 1])) <= {-1.0, 1.0}


def test_a_set_is_the_same_in_parts_of_any_size(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sets = []
    for size in (1, 2):
        monkeypatch.setattr(_sets, "PART", size)
        sets.append(example_set(tmp_path / str(size), 10, 2, SEED, Serial()))
        assert len(list((tmp_path / str(size)).iterdir())) == 2 // size
    assert same(*sets)


@pytest.mark.slow  # each worker imports for seconds
def test_a_set_is_the_same_whatever_the_workers(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(_sets, "PART", 1)
    serial = example_set(tmp_path / "a", 10, 2, SEED, Serial())
    with parallel(2) as runner:
        shared = example_set(tmp_path / "b", 10, 2, SEED, runner)
    assert same(serial, shared)
    names = [sorted(p.name for p in (tmp_path / x).iterdir()) for x in "ab"]
    assert names[0] == names[1]
    assert len(names[0]) == 2


def test_what_was_made_is_read_and_what_is_missing_made(tmp_path: Path) -> None:
    class Counting(Serial):
        jobs = 0

        def stream(self, function, jobs, *shared):  # type: ignore[no-untyped-def]
            Counting.jobs += len(jobs)
            return super().stream(function, jobs, *shared)

    first = example_set(tmp_path, 0, 2, SEED, Counting())
    assert Counting.jobs == 1
    assert same(first, example_set(tmp_path, 0, 2, SEED, Counting()))
    assert Counting.jobs == 1
    (file,) = tmp_path.iterdir()
    file.unlink()
    assert same(first, example_set(tmp_path, 0, 2, SEED, Counting()))
    assert Counting.jobs == 2


def test_a_separate_family_is_a_separate_set(tmp_path: Path) -> None:
    name = next(iter(FAMILIES))
    plain = example_set(tmp_path, 0, 1, SEED, Serial())
    other = example_set(tmp_path, 0, 1, SEED, Serial(), name)
    assert not np.array_equal(plain.signals, other.signals)
    assert len(list(tmp_path.iterdir())) == 2


def test_a_training_that_was_stopped_gives_what_it_would_have_given(tmp_path: Path) -> None:
    uninterrupted = training(few(), 3, SEED, tmp_path / "whole").run()

    def stop(epoch: int, loss: float) -> None:
        raise KeyboardInterrupt

    for _ in range(2):  # after the first and after the second pass
        with pytest.raises(KeyboardInterrupt):
            training(few(), 3, SEED, tmp_path / "parts").run(stop)
    epochs: list[int] = []
    parts = training(few(), 3, SEED, tmp_path / "parts").run(lambda e, loss: epochs.append(e))
    assert epochs == [3]
    assert np.array_equal(weights(uninterrupted), weights(parts))


def test_weights_depend_only_on_the_seed(tmp_path: Path) -> None:
    one, again, other = (
        weights(training(few(), 1, seed, tmp_path / name).run())
        for name, seed in (("a", 1), ("b", 1), ("c", 2))
    )
    assert np.array_equal(one, again)
    assert not np.array_equal(one, other)


def test_training_lowers_the_loss(tmp_path: Path) -> None:
    losses: list[float] = []
    training(few(), 10, SEED, tmp_path / "t").run(lambda e, loss: losses.append(loss))
    assert losses[-1] < losses[0]


def test_a_batch_is_what_the_network_takes(tmp_path: Path) -> None:
    examples = few()
    rows = np.arange(len(examples))
    batch = draw_batch(examples, rows, np.random.default_rng(0))
    assert batch.x.shape == (len(examples), INPUTS)
    assert np.isfinite(batch.x).all()
    assert 0 < batch.is_known.mean() <= 1
    tokens, present = token_rows(examples)
    assert batch.row.max() < len(tokens) == len(present)
    assert (present.sum(axis=1) >= 2).all()
    # Later signal is not in what is drawn after so many samples.
    early = draw_batch(examples, rows, np.random.default_rng(0), samples=20, context=0)
    later = examples.signals.copy()
    later[:, -30:] = 0
    changed = Examples(**{f.name: getattr(examples, f.name) for f in fields(Examples)} | {
        "signals": later
    })  # fmt: skip
    same_again = draw_batch(changed, rows, np.random.default_rng(0), samples=20, context=0)
    assert np.array_equal(early.x, same_again.x)


def test_intervals_cover_their_share_of_the_calibration_data(tmp_path: Path) -> None:
    examples = few()
    from firstcontact_lab.pretraining._compact_training import compacted

    full = training(examples, 2, SEED, tmp_path / "t").run()
    model = finished(compacted(full, examples, SEED, 3), examples, SEED)
    objects = examples.object_ids >= 0
    for samples in (STAGES[0], STAGES[5], STAGES[-1]):
        values, spreads = answers(model, examples, samples, SEED)
        is_covered = np.abs(values - examples.shore_a) <= model.half_widths(spreads, samples)
        share = is_covered[objects].mean()
        assert LEVEL <= share <= LEVEL + 2 / objects.sum() + 0.01
