"""ONNX Runtime answers what PyTorch would, without PyTorch."""

from __future__ import annotations

import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import torch

from firstcontact.core import InputError
from firstcontact.stiffness import Card, Task, graph, save_model
from firstcontact.stiffness.cnn import Cnn, as_input
from firstcontact.stiffness.efficientnet import EfficientNet
from firstcontact.testing.windows import RATE, toy_windows


@pytest.mark.parametrize(("samples", "channels", "outputs"), [(74, 1, 1), (10, 2, 5), (241, 1, 3)])
def test_the_graph_is_the_network(samples: int, channels: int, outputs: int) -> None:
    from onnxruntime import InferenceSession

    torch.manual_seed(0)
    network = EfficientNet(channels, outputs)
    windows = np.random.default_rng(0).normal(size=(64, samples, channels)).astype(np.float32)
    x = as_input(windows)
    for _ in range(5):  # normalisations that are not the identity
        network(x)
    network.eval()
    with torch.no_grad():
        expected = network(x).numpy()
    session = InferenceSession(
        graph.build(network.weights(), samples, channels, outputs),
        providers=["CPUExecutionProvider"],
    )
    told = session.run(None, {"window": np.ascontiguousarray(x.numpy())})[0]
    np.testing.assert_allclose(told, expected, atol=1e-4)


def test_it_is_an_efficientnet_v2() -> None:
    kinds = [type(m).__name__ for m in EfficientNet(1, 1).modules()]
    assert kinds.count("SqueezeExcitation") == 2
    assert "SiLU" in kinds
    assert EfficientNet(1, 1)(torch.zeros(2, 1, 1, 74)).shape == (2, 1)


def test_training_leaves_the_random_state_of_others_alone() -> None:
    X, y, _ = toy_windows(32)
    torch.manual_seed(5)
    expected = torch.rand(3)
    torch.manual_seed(5)
    Cnn(Task.REGRESSION, RATE, epochs=1).fit(X, y)
    assert torch.equal(torch.rand(3), expected)


def test_other_weights_are_refused() -> None:
    weights = EfficientNet(1, 1).weights()
    with pytest.raises(InputError, match=r"head\.bias"):
        graph.build({k: v for k, v in weights.items() if k != "head.bias"}, 74, 1, 1)
    with pytest.raises(InputError, match=r"last\.weight"):
        graph.build(weights, 74, 1, 5)
    with pytest.raises(InputError, match=r"stem\.weight"):
        graph.build(weights, 74, 2, 1)


def test_a_model_travels_between_processes() -> None:
    X, y, _ = toy_windows(32)
    model = Cnn(Task.REGRESSION, RATE, epochs=1).fit(X, y)
    travelled = pickle.loads(pickle.dumps(model))
    np.testing.assert_array_equal(travelled.predict(X), model.predict(X))


def test_running_a_saved_model_imports_no_training_library(tmp_path: Path) -> None:
    X, y, _ = toy_windows(32)
    save_model(Cnn(Task.REGRESSION, RATE, epochs=1).fit(X, y), tmp_path / "model", Card())
    np.save(tmp_path / "window.npy", X[0])
    script = (
        "import sys, numpy as np; from pathlib import Path; "
        "from firstcontact.stiffness import load_model; "
        f"folder = Path({str(tmp_path)!r}); "
        "load_model(folder / 'model').predict_one(np.load(folder / 'window.npy')); "
        "assert not {'torch', 'sklearn'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-W", "error", "-c", script], check=True)
