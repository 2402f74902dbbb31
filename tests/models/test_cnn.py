"""ONNX Runtime gives PyTorch's outputs without PyTorch."""

from __future__ import annotations

import pickle
import subprocess
import sys
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from firstcontact.models import Task
from firstcontact.models._cnn import CheckedGraph, Cnn, as_input, export
from firstcontact.testing._windows import RATE, toy_windows
from saved import load_window, save_window

if TYPE_CHECKING:
    from firstcontact.models._efficientnet import EfficientNet

#: The shortest, the usual and the longest window; the slow tests have all combinations.
FEW = {(10, 2, 1), (74, 1, 5), (241, 2, 5)}


# Only the process that runs these tests imports PyTorch: all processes collect them.
def make(channels: int, outputs: int) -> EfficientNet:
    from firstcontact.models._efficientnet import EfficientNet

    return EfficientNet(channels, outputs)


def used(channels: int, outputs: int, samples: int = 74) -> tuple[EfficientNet, Any]:
    """Return a network with normalisations that are not the identity, and windows (n, samples)."""
    import torch

    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(0)
        network = make(channels, outputs)
        windows = np.random.default_rng(0).normal(size=(64, samples, channels))
        x = as_input(windows.astype(np.float32))
        for _ in range(5):
            network(x)
    return network.eval(), x


@pytest.mark.parametrize(
    ("samples", "channels", "outputs"),
    [
        pytest.param(*shape, marks=() if shape in FEW else pytest.mark.slow)
        for shape in product((10, 15, 25, 39, 74, 241), (1, 2), (1, 5))
    ],
)
def test_the_export_is_the_network(samples: int, channels: int, outputs: int) -> None:
    import torch

    network, x = used(channels, outputs, samples)
    with torch.no_grad():
        expected = network(x).numpy()
    exported = CheckedGraph(export(network, samples), samples, channels, outputs)
    predictions = exported.run(np.ascontiguousarray(x.numpy()))
    np.testing.assert_allclose(predictions, expected, atol=1e-4 * np.abs(expected).max())


@pytest.mark.parametrize("task", Task)
def test_a_trained_network_answers_as_in_pytorch(
    task: Task, monkeypatch: pytest.MonkeyPatch
) -> None:
    import torch

    from firstcontact.models import _cnn as cnn
    from firstcontact.models._cnn import compress

    trained = []
    train = cnn._train
    monkeypatch.setattr(cnn, "_train", lambda *a: trained.extend(train(*a)) or trained)
    X, y, _ = toy_windows(64)
    model = Cnn(task, RATE, epochs=2).fit(X, y)
    with torch.no_grad():
        expected = trained[0](as_input(compress(X, model.to_arrays()["scale"]))).numpy()
    scale = np.abs(expected).max()
    np.testing.assert_allclose(model.outputs(X), expected, atol=1e-4 * scale)
    np.testing.assert_allclose(model.output(X[3]), expected[3], atol=1e-4 * scale)


@pytest.mark.slow
def test_the_same_weights_are_the_same_bytes_in_another_process(tmp_path: Path) -> None:
    import torch

    network, _ = used(1, 1)
    script = (
        "import sys, torch; "
        "from firstcontact.models._cnn import export; "
        "from firstcontact.models._efficientnet import EfficientNet; "
        "export(EfficientNet(2, 3), 15); "
        "n = EfficientNet(1, 1); n.load_state_dict(torch.load(sys.argv[1])); "
        "sys.stdout.buffer.write(export(n, 74))"
    )

    torch.save(network.state_dict(), tmp_path / "weights")
    other = subprocess.run(
        [sys.executable, "-W", "error", "-c", script, str(tmp_path / "weights")],
        capture_output=True,
        check=True,
    )
    assert other.stdout == export(network, 74)
    assert other.stderr == b""
    assert b".py" not in other.stdout  # no paths of the machine that trained


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


def test_running_a_saved_model_imports_no_training_library(tmp_path: Path) -> None:
    X, y, _ = toy_windows(32)
    model = Cnn(Task.REGRESSION, RATE, epochs=1).fit(X, y)
    save_window(model, tmp_path / "model")
    assert load_window(tmp_path / "model").predict_one(X[0]) == model.predict_one(X[0])
    np.save(tmp_path / "window.npy", X[0])
    script = (
        "import sys, numpy as np; from pathlib import Path; "
        "from firstcontact.models import load_model; "
        f"folder = Path({str(tmp_path)!r}); "
        "model = load_model(folder / 'model').windows[0].model; "
        "model.predict_one(np.load(folder / 'window.npy')); "
        "assert not {'torch', 'sklearn', 'onnxscript'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-W", "error", "-c", script], check=True)
