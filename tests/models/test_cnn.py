"""ONNX Runtime gives PyTorch's outputs without PyTorch."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from firstcontact.core import InputError
from firstcontact.models import Spec, Task
from firstcontact.models.windows.cnn import Cnn, CnnModel, as_input, compress, exported_weights
from firstcontact.testing.synthetic import RATE, toy_windows
from saved import load_window, save_window

if TYPE_CHECKING:
    from firstcontact.models.windows.efficientnet import EfficientNet

#: The shortest, the usual and the longest window; the slow tests have all combinations.
FEW = {(10, 2, 1), (74, 1, 5), (241, 2, 5)}
#: Amplitude, mean and standard deviation of windows.
UNIT = np.array([1.0, 0.0, 1.0])


# Only the process that runs these tests imports PyTorch: all processes collect them.
def make(channels: int, outputs: int) -> EfficientNet:
    from firstcontact.models.windows.efficientnet import EfficientNet

    return EfficientNet(channels, outputs)


def used(channels: int, outputs: int, samples: int = 74) -> tuple[EfficientNet, Any]:
    """Return a network with normalisations that are not the identity, and windows (n, samples)."""
    import torch

    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(0)
        network = make(channels, outputs)
        X = np.random.default_rng(0).normal(size=(64, samples, channels)).astype(np.float32)
        for _ in range(5):
            network(as_input(compress(X, UNIT)))
    return network.eval(), X


def exported(network: EfficientNet, samples: int) -> CnnModel:
    """Return a model with the weights of a network."""
    outputs = network.last.out_features
    classes = () if outputs == 1 else tuple(map(float, range(outputs)))
    task = Task.CLASSIFICATION if classes else Task.REGRESSION
    spec = Spec(task, RATE, samples, network.channels, classes)
    return CnnModel(spec, UNIT, np.array([0.0, 1.0]), np.zeros(2), exported_weights(network))


@pytest.mark.parametrize(
    ("samples", "channels", "outputs"),
    [
        pytest.param(*shape, marks=() if shape in FEW else pytest.mark.slow)
        for shape in product((10, 15, 25, 39, 74, 241), (1, 2), (1, 5))
    ],
)
def test_the_export_is_the_network(samples: int, channels: int, outputs: int) -> None:
    import torch

    network, X = used(channels, outputs, samples)
    with torch.no_grad():
        expected = network(as_input(compress(X, UNIT))).numpy()
    model = exported(network, samples)
    np.testing.assert_allclose(model.outputs(X), expected, atol=1e-4 * np.abs(expected).max())
    weights = model.to_arrays()["weights"]
    for wrong in (weights[:-1], np.append(weights, weights[:1]), weights * np.nan):
        with pytest.raises(InputError):
            CnnModel.from_arrays(model.spec, {**model.to_arrays(), "weights": wrong})


@pytest.mark.slow
def test_shipped_graph_is_that_of_the_exporter() -> None:
    from onnx import ModelProto
    from shipped_graph import GRAPH, traced_graph

    traced, shipped = traced_graph().graph, ModelProto.FromString(GRAPH.read_bytes()).graph
    assert [node.op_type for node in shipped.node] == [node.op_type for node in traced.node]
    assert {w.name for w in shipped.initializer} == {w.name for w in traced.initializer}


@pytest.mark.parametrize("task", list(Task))
def test_several_trainings_at_once_are_those_of_each_alone(task: Task) -> None:
    X, y, _ = toy_windows(160)
    estimator = Cnn(task, RATE, epochs=1)
    sets = [(X[a:b], y[a:b], None) for a, b in ((0, 64), (20, 85), (0, 160), (96, 160))]
    for model, each in zip(estimator.fit_several(sets), sets, strict=True):
        alone = estimator.fit(*each)
        assert model.notes == alone.notes
        # Rounding moves standardised outputs by up to 0.0008 on some processors; training on
        # the windows in another order moves them by 0.005 to 0.07.
        np.testing.assert_allclose(model.outputs(X), alone.outputs(X), atol=0.003)


def test_training_leaves_the_random_state_of_others_alone() -> None:
    import torch

    X, y, _ = toy_windows(32)
    torch.manual_seed(5)
    expected = torch.rand(3)
    torch.manual_seed(5)
    Cnn(Task.REGRESSION, RATE, epochs=1).fit(X, y)
    assert torch.equal(torch.rand(3), expected)


def test_a_model_travels_between_processes() -> None:
    X, y, _ = toy_windows(32)
    model = Cnn(Task.REGRESSION, RATE, epochs=1).fit(X, y)
    travelled = pickle.loads(pickle.dumps(model))
    np.testing.assert_array_equal(travelled.predict(X), model.predict(X))


#: Variables that would place caches elsewhere, or switch telemetry off from outside.
ELSEWHERE = ("XDG_CACHE_HOME", "XDG_DATA_HOME", "XDG_CONFIG_HOME", "ORT_DISABLE_TELEMETRY")


def test_a_saved_model_needs_no_training_library_and_leaves_no_files(tmp_path: Path) -> None:
    X, y, _ = toy_windows(32)
    model = Cnn(Task.REGRESSION, RATE, epochs=1).fit(X, y)
    save_window(model, tmp_path / "model")
    assert load_window(tmp_path / "model").predict(X[:1]) == model.predict(X[:1])
    np.save(tmp_path / "window.npy", X[:1])
    script = (
        "import sys, numpy as np; from pathlib import Path; "
        "from firstcontact.models import load_model; "
        f"folder = Path({str(tmp_path)!r}); "
        "model = load_model(folder / 'model').windows[0].model; "
        "model.predict(np.load(folder / 'window.npy')); "
        "assert not {'torch', 'sklearn', 'onnxscript'} & set(sys.modules)"
    )
    home = tmp_path / "home"
    home.mkdir()
    environment = {name: value for name, value in os.environ.items() if name not in ELSEWHERE}
    command = [sys.executable, "-W", "error", "-c", script]
    subprocess.run(command, env={**environment, "HOME": str(home)}, check=True)
    assert [path for path in home.rglob("*") if not path.is_dir()] == []
