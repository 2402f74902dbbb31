"""Inference of the convolutional network by ONNX Runtime, on one thread, without PyTorch."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import InputError
from firstcontact.models._network import Network
from firstcontact.models._spec import Spec, Windows
from firstcontact.models._window_model import TARGET, ArrayCheck, ArraysModel

#: Number of windows for one call of ONNX Runtime. More only cost memory.
_BATCH = 256


def compress(X: NDArray[Any], scale: NDArray[np.float64]) -> NDArray[np.float32]:
    """Return the input of the network: arcsinh of the window divided by a typical amplitude."""
    out: NDArray[np.float32] = np.arcsinh(X * np.float32(1.0 / scale[0]), dtype=np.float32)
    out -= np.float32(scale[1])
    out *= np.float32(1.0 / scale[2])
    return out


class CnnModel(ArraysModel):
    """Window model: an EfficientNetV2 for one dimension, exported from PyTorch."""

    kind: ClassVar[str] = "cnn"
    modules: ClassVar[tuple[str, ...]] = ("onnx", "onnxruntime")
    extra: ClassVar[str] = "cnn"

    declared: ClassVar[Mapping[str, ArrayCheck]] = {
        "scale": ArrayCheck((3,), positive=slice(0, 3, 2)),
        "target": TARGET,
        "training": ArrayCheck((2,)),
        "onnx": ArrayCheck(("bytes",), dtype=np.uint8),
    }

    def __init__(self, spec: Spec, *arrays: NDArray[Any]) -> None:
        super().__init__(spec, *arrays)
        self._scale, _, self._training, onnx = self._arrays.values()
        if self._training.min() < 0:
            raise InputError("the CNN's field 'epochs' or 'batch' is below 0: train the CNN again")
        self._raw = onnx.tobytes()
        self._network = Network(self._raw, spec.samples, spec.channels, len(spec.classes) or 1)

    @property
    def notes(self) -> Mapping[str, Any]:
        """Return epochs, batch and size of the network."""
        epochs, batch = self._training
        return {
            "epochs": int(epochs),
            "batch": int(batch),
            "parameters": self._network.parameters,
            "amplitude_v": float(self._scale[0]),
        }

    def outputs(self, X: Windows) -> NDArray[np.float32]:
        """Return the raw outputs of the network, shape (n, outputs)."""
        windows = compress(X, self._scale).transpose(0, 2, 1)[:, :, None, :]
        parts = [
            self._network.run(np.ascontiguousarray(windows[i : i + _BATCH]))
            for i in range(0, len(windows), _BATCH)
        ]
        width = len(self.spec.classes) or 1
        return np.concatenate(parts) if parts else np.zeros((0, width), dtype=np.float32)

    def output(self, window: Windows) -> NDArray[np.float32]:
        """Return the output for one window (samples, channels), shape (outputs,)."""
        x = compress(window, self._scale).T.reshape(1, self.spec.channels, 1, self.spec.samples)
        out: NDArray[np.float32] = self._network.run(np.ascontiguousarray(x))[0]
        return out

    def __reduce__(self) -> tuple[Any, ...]:
        # A session of ONNX Runtime cannot be pickled, but the arrays that it is built from can.
        return type(self).from_arrays, (self.spec, self.to_arrays())
