"""Compact network: it begins like the full network, and equal seeds give equal weights."""

from __future__ import annotations

from functools import cache
from importlib.util import find_spec
from typing import TYPE_CHECKING

import numpy as np
import pytest

from firstcontact.chain import INPUTS, predict_inputs
from firstcontact.models import GENERAL, STAGES, TOKEN, Network
from firstcontact_lab.pretraining._examples import Examples, joined, rig_examples
from firstcontact_lab.pretraining._finishing import finished

if TYPE_CHECKING:
    from firstcontact_lab.pretraining._training import Full

pytestmark = pytest.mark.skipif(find_spec("torch") is None, reason="PyTorch is not installed")
#: As many directions as a layer has outputs: its low-rank form is exact.
ALL = {"query1": 256, "body1": 256, "body2": 256, "body3": 128}


@cache
def few() -> Examples:
    return joined([rig_examples(number, 5) for number in range(3)])


@cache
def full() -> Full:
    import torch

    from firstcontact_lab.pretraining._torch_network import TorchNetwork
    from firstcontact_lab.pretraining._training import Full, _scales

    torch.manual_seed(0)
    return Full(TorchNetwork(), _scales(few(), 0))


def compacted(steps: int = 0, directions: dict[str, int] | None = None) -> Network:
    from firstcontact_lab.pretraining import _compact_training

    directions = directions or dict(_compact_training.DIRECTIONS)
    return _compact_training.compacted(full(), few(), 1, steps, directions)


def test_sums_of_integers_fit_in_32_bits() -> None:
    from firstcontact_lab.pretraining._compact_training import integers

    rng = np.random.default_rng(0)
    weight = rng.standard_normal((20, 300)) * rng.choice([1e-6, 1.0, 1e6], (20, 1))
    arrays = integers("a", weight)
    assert (np.abs(arrays["a.weight"].astype(int)).sum(axis=1) * 32767 < 2**31).all()
    again = arrays["a.weight"] * arrays["a.scale"][:, None].astype(np.float64)
    assert (np.abs(again - weight) <= 0.51 * arrays["a.scale"][:, None]).all()


def test_with_all_directions_the_chain_predicts_as_the_full_network() -> None:
    import torch

    from firstcontact_lab.pretraining._torch_network import CENTRE, UNIT

    network = compacted(directions=ALL)
    model = finished(network, few(), 0)
    rng, scales = np.random.default_rng(1), full().scales
    scaled = {
        "inputs": rng.standard_normal((40, INPUTS)),
        "token": rng.standard_normal((len(STAGES), 1, TOKEN)),  # one level: nothing to attend to
        "general": rng.standard_normal(GENERAL),
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
    one, other = compacted(3).to_arrays(), compacted(3).to_arrays()
    assert one.keys() == other.keys()
    assert all(np.array_equal(one[name], other[name]) for name in one)


@pytest.mark.parametrize("levels", [0, 1, 5])
def test_any_number_of_levels_gives_a_finite_term(levels: int) -> None:
    rng = np.random.default_rng(2)
    tokens = rng.standard_normal((len(STAGES), levels, TOKEN))
    assert np.isfinite(compacted().rig_term(tokens, np.zeros(GENERAL))).all()
