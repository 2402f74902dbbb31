"""Pre-training: one seed gives the same weights, also after a stop; compact form; shared errors."""

from __future__ import annotations

from dataclasses import fields
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from firstcontact.chain.touch import INPUTS, predict_inputs
from firstcontact.jobs import Serial, parallel
from firstcontact.models.model_file import pretrained_folder, read_card
from firstcontact.models.predictions import SHARED
from firstcontact.models.rig.context_network import ContextNetwork
from firstcontact.models.rig.rigs import Rig
from firstcontact_lab.pretraining import examples as example_files
from firstcontact_lab.pretraining.batches import draw_batch, token_rows
from firstcontact_lab.pretraining.calibration import (
    LEVEL,
    PINCHES,
    answers,
    calibrate_network,
    coverage,
    shared_part,
)
from firstcontact_lab.pretraining.examples import Examples, example_set, joined, rig_examples

if TYPE_CHECKING:
    from firstcontact_lab.pretraining.training import Full, Training

pytestmark = pytest.mark.skipif(find_spec("torch") is None, reason="PyTorch is not installed")
SEED = 5


def training(*arguments: Any) -> Training:
    """Start a training. Only the process that runs it imports PyTorch."""
    from firstcontact_lab.pretraining.training import Training

    return Training(*arguments)


@pytest.fixture(autouse=True)
def _small_rigs(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Pinch few objects and blocks on each rig, except where other processes pinch the rigs."""
    if "whatever_the_workers" not in request.node.name:
        monkeypatch.setattr(example_files, "THINGS", 8)
        monkeypatch.setattr(example_files, "CONTEXT", (4, 6))


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


@pytest.mark.slow  # each worker imports for seconds
def test_a_set_is_the_same_whatever_the_workers(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(example_files, "RIGS_PER_FILE", 1)
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
    from firstcontact_lab.pretraining.compact_training import train_compact

    full = training(examples, 2, SEED, tmp_path / "t").run()
    model = calibrate_network(train_compact([full], examples, SEED, 3), examples, SEED)
    objects = examples.object_ids >= 0
    for samples in (Rig.STAGES[0], Rig.STAGES[5], Rig.STAGES[-1]):
        values, spreads = answers(model, examples, samples, SEED)
        is_covered = np.abs(values - examples.shore_a) <= model.half_widths(spreads, samples)
        share = is_covered[objects].mean()
        assert LEVEL <= share <= LEVEL + 2 / objects.sum() + 0.01


#: As many directions as a layer has outputs: its low-rank form is exact.
ALL = {"query1": 256, "body1": 256, "body2": 256, "body3": 128}


@cache
def three_rigs() -> Examples:
    return joined([rig_examples(number, 5) for number in range(3)])


@cache
def full() -> Full:
    import torch

    from firstcontact_lab.pretraining.training import Full, TorchNetwork, input_scales

    torch.manual_seed(0)
    return Full(TorchNetwork(), input_scales(three_rigs(), 0))


def train_compact(
    steps: int = 0, directions: dict[str, int] | None = None, teachers: int = 1
) -> ContextNetwork:
    from firstcontact_lab.pretraining import compact_training

    directions = directions or dict(compact_training.DIRECTIONS)
    return compact_training.train_compact([full()] * teachers, three_rigs(), 1, steps, directions)


def test_sums_of_integers_fit_in_32_bits() -> None:
    from firstcontact_lab.pretraining.compact_training import quantize_rows

    rng = np.random.default_rng(0)
    weight = rng.standard_normal((20, 300)) * rng.choice([1e-6, 1.0, 1e6], (20, 1))
    arrays = quantize_rows("a", weight)
    assert (np.abs(arrays["a.weight"].astype(int)).sum(axis=1) * 32767 < 2**31).all()
    again = arrays["a.weight"] * arrays["a.scale"][:, None].astype(np.float64)
    assert (np.abs(again - weight) <= 0.51 * arrays["a.scale"][:, None]).all()


def test_with_all_directions_the_chain_predicts_as_the_full_network() -> None:
    import torch

    from firstcontact_lab.pretraining.training import CENTRE, UNIT

    network = train_compact(directions=ALL)
    model = calibrate_network(network, three_rigs(), 0)
    rng, scales = np.random.default_rng(1), full().scales
    scaled = {
        "inputs": rng.standard_normal((40, INPUTS)),
        "token": rng.standard_normal((len(Rig.STAGES), 1, Rig.TOKEN)),
        "general": rng.standard_normal(Rig.GENERAL),
    }
    x, tokens, general = (
        values * scales[f"{name}.sd"] + scales[f"{name}.mean"] for name, values in scaled.items()
    )
    terms = np.repeat(network.rig_term(tokens, general)[3:4], 40, axis=0)
    value, spread = predict_inputs(model.image, x, terms).T
    single = {name: torch.from_numpy(values).float() for name, values in scaled.items()}
    with torch.no_grad():
        weight, mean, sd = (
            part.numpy().astype(np.float64)
            for part in full().network(
                single["inputs"],
                single["token"][3].expand(40, -1, -1),
                torch.ones(40, 1),
                single["general"].expand(40, -1),
            )
        )
    share, centre, sd = np.exp(weight), CENTRE + UNIT * mean, UNIT * np.exp(sd)
    expected = (share * centre).sum(axis=1)
    assert value == pytest.approx(expected, abs=0.2)
    square = (share * (sd**2 + centre**2)).sum(axis=1)
    assert spread == pytest.approx(np.sqrt(square - expected**2), rel=1e-2)


def test_equal_seeds_give_equal_weights() -> None:
    one, other = train_compact(3).to_arrays(), train_compact(3).to_arrays()
    assert one.keys() == other.keys()
    assert all(np.array_equal(one[name], other[name]) for name in one)


def test_two_equal_teachers_teach_as_one() -> None:
    one, two = train_compact(3).to_arrays(), train_compact(3, teachers=2).to_arrays()
    for name in ("answer.bias", "answer.weight", "term.weight"):
        assert two[name] == pytest.approx(one[name], abs=1e-4), name


@pytest.mark.parametrize("part", [0.0, 0.5, 0.9, 1.0])
def test_the_shared_part_of_errors_is_recovered(part: float) -> None:
    rng = np.random.default_rng(0)
    n = 20_000
    truth, half = np.full(n, 40.0), rng.uniform(5, 20, (n, PINCHES))
    error = part * rng.standard_normal((n, 1)) + np.sqrt(1 - part**2) * rng.standard_normal(
        (n, PINCHES)
    )
    values = truth[:, None] + half / 1.6449 * error
    assert shared_part(values, half, truth) == pytest.approx(part, abs=0.09 if part < 0.1 else 0.02)
    if part == 0.9:
        # Of Gaussian errors with about the share that is taken, as many are held as of one.
        assert coverage(values, half, truth, 1) == pytest.approx(0.9, abs=0.01)
        assert coverage(values, half, truth, PINCHES) == pytest.approx(0.9, abs=0.02)


def test_the_share_that_is_taken_is_the_one_that_was_measured() -> None:
    results = read_card(pretrained_folder()).predictors[0].record.scores["same object"]["ms"]
    assert round(max(entry["shared"] for entry in results.values()), 2) == SHARED
    assert all(
        0.85 <= is_covered <= 0.92
        for entry in results.values()
        for is_covered in entry["coverage"].values()
    )


def test_flat_objects_are_told_and_untold_ones_are_round() -> None:
    made = joined([rig_examples(number, 1) for number in range(6)])
    rows = np.tile(np.arange(len(made)), 4)
    is_flat = made.radii[rows] > 0.2
    for context in (None, 0):
        batch = draw_batch(made, rows, np.random.default_rng(0), context=context)
        has_radius, curvature = batch.x[:, -2] > 0, batch.x[:, -1]
        assert has_radius[is_flat].all()
        assert not curvature[is_flat].any()
        told = has_radius[~is_flat].mean()
        assert told == (pytest.approx(0.3, abs=0.05) if context is None else 0)
        assert (curvature[~is_flat & has_radius] > 0).all()


def test_rigs_that_measure_speeds_miss_some() -> None:
    made = joined([rig_examples(number, 1) for number in range(6)])
    rows = np.tile(np.arange(len(made)), 8)
    batch = draw_batch(made, rows, np.random.default_rng(0))
    measures = batch.general[:, -1] > 0
    is_exact = np.isclose(batch.x[:, -3], 1.0)
    assert measures.mean() == pytest.approx(0.92 * 0.25, abs=0.03)
    assert is_exact[measures].mean() == pytest.approx(0.75, abs=0.05)
