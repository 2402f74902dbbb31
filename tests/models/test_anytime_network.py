"""The network in NumPy equals the PyTorch network."""

from __future__ import annotations

from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from firstcontact.core import InputError
from firstcontact.models import (
    CENTRE,
    GENERAL,
    INPUTS,
    STAGES,
    TOKEN,
    UNIT,
    Network,
    mean_and_spread,
)

if TYPE_CHECKING:
    from firstcontact_lab.pretraining._torch_network import TorchNetwork

pytestmark = pytest.mark.skipif(find_spec("torch") is None, reason="PyTorch is not installed")
N = 17


def scales(rng: np.random.Generator) -> dict[str, np.ndarray]:
    out = {}
    for name, size in (("inputs", INPUTS), ("token", TOKEN), ("general", GENERAL)):
        out[f"{name}.mean"] = rng.standard_normal(size).astype(np.float32)
        out[f"{name}.sd"] = rng.uniform(0.5, 2.0, size).astype(np.float32)
    return out


def pair(seed: int) -> tuple[TorchNetwork, Network, dict[str, np.ndarray]]:
    # Only the process that runs these tests imports PyTorch: all processes collect them.
    import torch

    from firstcontact_lab.pretraining._torch_network import TorchNetwork

    torch.manual_seed(seed)
    trained, of = TorchNetwork(), scales(np.random.default_rng(seed))
    return trained, Network({**trained.arrays(), **of}), of


@pytest.mark.parametrize("levels", [0, 1, 5, 8])
@pytest.mark.parametrize("seed", [0, 1])
def test_both_answer_alike(levels: int, seed: int) -> None:
    import torch

    trained, runs, of = pair(seed)
    rng = np.random.default_rng(seed + 100)
    x = 3 * rng.standard_normal((N, INPUTS))
    tokens = 3 * rng.standard_normal((len(STAGES), levels, TOKEN))
    general = rng.standard_normal(GENERAL)
    stages = rng.integers(0, len(STAGES), N)
    weight, mean, sd = runs.outputs(x, runs.context(tokens, general), stages)

    def ready(name: str, values: np.ndarray) -> Any:
        scaled = (values - of[f"{name}.mean"]) / of[f"{name}.sd"]
        return torch.from_numpy(scaled.astype(np.float32))

    padded = np.zeros((N, 8, TOKEN))
    padded[:, :levels] = tokens[stages]
    present = torch.zeros(N, 8)
    present[:, :levels] = 1
    with torch.no_grad():
        theirs = trained(
            ready("inputs", x),
            ready("token", padded) * present[..., None],
            present,
            ready("general", np.tile(general, (N, 1))),
        )
    logs, centre, spread = (t.numpy().astype(np.float64) for t in theirs)
    assert weight == pytest.approx(np.exp(logs), abs=1e-4)
    assert mean == pytest.approx(CENTRE + UNIT * centre, abs=1e-4 * UNIT)
    assert sd == pytest.approx(UNIT * np.exp(spread), rel=1e-4, abs=1e-4)


def test_the_order_of_the_levels_does_not_matter() -> None:
    _, runs, _ = pair(3)
    rng = np.random.default_rng(3)
    x, general = rng.standard_normal((N, INPUTS)), rng.standard_normal(GENERAL)
    tokens = rng.standard_normal((len(STAGES), 5, TOKEN))
    stages = np.zeros(N, np.intp)
    one, other = (
        runs.outputs(x, runs.context(t, general), stages) for t in (tokens, tokens[:, ::-1])
    )
    assert one == pytest.approx(other, abs=1e-3)


def test_inputs_that_are_far_out_stay_finite() -> None:
    _, runs, _ = pair(0)
    for far in (1e30, -1e30):
        context = runs.context(np.full((len(STAGES), 3, TOKEN), far), np.full(GENERAL, far))
        assert np.isfinite(runs.outputs(np.full((1, INPUTS), far), context, np.zeros(1, int))).all()


def test_arrays_are_given_back() -> None:
    _, runs, _ = pair(0)
    again = Network(runs.to_arrays()).to_arrays()
    for name, array in runs.to_arrays().items():
        assert np.array_equal(array, again[name])


def test_every_array_is_required_and_checked() -> None:
    _, runs, _ = pair(0)
    arrays = runs.to_arrays()
    for name, array in arrays.items():
        for bad in (array[:-1], array * np.nan, array[None]):
            with pytest.raises(InputError):
                Network({**arrays, name: bad})
        with pytest.raises(InputError, match="missing"):
            Network({n: a for n, a in arrays.items() if n != name})


def test_mean_and_spread_of_a_mixture_in_closed_form() -> None:
    mixture = np.array([[[0.5, 0.5, 0.0]], [[10.0, 30.0, 99.0]], [[3.0, 4.0, 1.0]]])
    value, sd = mean_and_spread(mixture)
    assert value[0] == pytest.approx(20.0)
    assert sd[0] == pytest.approx(np.sqrt(0.5 * (9 + 16) + 100))
