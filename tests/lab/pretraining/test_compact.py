"""Compact network: its sums are exact, and equal seeds give equal weights."""

from __future__ import annotations

from functools import cache
from importlib.util import find_spec

import numpy as np
import pytest
from firstcontact_lab.pretraining._compact_network import (
    CompactNetwork,
    compact_outputs,
    integers,
    mixtures,
    product,
    rig_term,
)

from firstcontact.models import CENTRE, GENERAL, INPUTS, STAGES, TOKEN, UNIT, pretrained
from firstcontact_lab.pretraining._examples import Examples, joined, rig_examples
from firstcontact_lab.pretraining._finishing import answers

pytestmark = pytest.mark.skipif(find_spec("torch") is None, reason="PyTorch is not installed")
#: As many directions as a layer has outputs: its low-rank form is exact.
ALL = {"query1": 256, "body1": 256, "body2": 256, "body3": 128}


@cache
def few() -> Examples:
    return joined([rig_examples(number, 5) for number in range(3)])


def compacted(steps: int = 0, directions: dict[str, int] | None = None) -> CompactNetwork:
    from firstcontact_lab.pretraining import _compact_training

    directions = directions or dict(_compact_training.DIRECTIONS)
    return _compact_training.compacted(pretrained().network, few(), 1, steps, directions)


def test_sums_are_exact_and_fit_in_32_bits() -> None:
    rng = np.random.default_rng(0)
    weight = rng.standard_normal((20, 300)) * rng.choice([1e-6, 1.0, 1e6], (20, 1))
    x = rng.standard_normal((50, 300)).astype(np.float32)
    arrays = integers("a", weight)
    assert (np.abs(arrays["a.weight"].astype(int)).sum(axis=1) * 32767 < 2**31).all()
    exact = x @ weight.T
    error = np.abs(product(arrays, "a", x) - exact) / np.abs(weight).sum(axis=1)
    assert error.max() < 1e-3


def test_inputs_of_zero_give_zero() -> None:
    arrays = integers("a", np.ones((3, 5)))
    assert not product(arrays, "a", np.zeros((2, 5), np.float32)).any()


def test_with_all_directions_only_attention_differs() -> None:
    value, spread = answers(pretrained().network, few(), 26)
    near, near_spread = answers(compacted(directions=ALL), few(), 26)
    assert np.median(np.abs(near - value)) < 1.0
    assert np.median(np.abs(np.log(near_spread / spread))) < 0.1


def test_equal_seeds_give_equal_weights() -> None:
    one, other = compacted(3).arrays, compacted(3).arrays
    assert one.keys() == other.keys()
    assert all(np.array_equal(one[name], other[name]) for name in one)


def test_numpy_predicts_as_torch_does() -> None:
    import torch

    from firstcontact_lab.pretraining import _compact_training as training

    torch.manual_seed(0)
    network = pretrained().network
    trained = training._TorchCompact(training.DIRECTIONS)
    arrays = trained.arrays(network)
    rng = np.random.default_rng(1)
    scaled = {
        "inputs": rng.standard_normal((40, INPUTS)),
        "token": rng.standard_normal((len(STAGES), 4, TOKEN)),
        "general": rng.standard_normal(GENERAL),
    }
    x, tokens, general = (
        values * network.scale(name)[1] + network.scale(name)[0] for name, values in scaled.items()
    )
    term = rig_term(arrays, tokens, general)
    weight, mean, spread = mixtures(compact_outputs(arrays, x, term, 3))
    single = {name: torch.from_numpy(values).float() for name, values in scaled.items()}
    codes = training._torch_network(network).encoded(single["token"][3]).expand(40, -1, -1)
    outputs = trained(single["inputs"], codes, torch.ones(40, 4), single["general"].expand(40, -1))
    expected = [part.detach().numpy() for part in outputs]
    np.testing.assert_allclose(weight, np.exp(expected[0]), atol=1e-3)
    np.testing.assert_allclose(mean, CENTRE + UNIT * expected[1], atol=0.1)
    np.testing.assert_allclose(spread, UNIT * np.exp(expected[2]), rtol=1e-2)


@pytest.mark.parametrize("levels", [0, 1, 5])
def test_the_term_of_a_rig_depends_on_no_order_of_levels(levels: int) -> None:
    arrays = compacted().arrays
    rng = np.random.default_rng(2)
    tokens, general = rng.standard_normal((len(STAGES), levels, TOKEN)), np.zeros(GENERAL)
    term = rig_term(arrays, tokens, general)
    assert term.shape == (len(STAGES), len(arrays["rig.weight"]))
    assert np.isfinite(term).all()
    np.testing.assert_allclose(rig_term(arrays, tokens[:, ::-1], general), term, atol=1e-4)
