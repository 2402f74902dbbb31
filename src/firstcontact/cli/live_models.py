"""Choice of the model for ``firstcontact live``: on the device, in a folder, or the shipped one."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from firstcontact.core import InputError

if TYPE_CHECKING:
    from firstcontact.core import Calibration
    from firstcontact.device import DevicePredictor
    from firstcontact.models import Model
    from firstcontact.streaming import Predictor

#: Note for a session without a model.
SHIPPED = (
    "no --model: the model of the package predicts, which does not know this rig. Its intervals "
    "are wide, and `firstcontact adapt` narrows them with a few pinches of blocks"
)


def live_model(folder: Path | None, detector: Path | None) -> Model:
    """Return the model in ``folder``, or else the shipped model.

    The detector in the folder ``detector`` replaces the model's own.
    """
    from dataclasses import replace

    from firstcontact.contact import load_detector
    from firstcontact.models import load_model, shipped_model

    separate_detector = None if detector is None else load_detector(detector)
    if folder is not None:
        return load_model(folder, separate_detector)
    model = shipped_model()
    return model if separate_detector is None else replace(model, detector=separate_detector)


def left_out(model: Model, predictor: Predictor | None, estimator: str | None) -> str:
    """Return a note if the network cannot predict because of its sampling rate, else ""."""
    network = model.network
    if estimator is not None or network is None or predictor is None:
        return ""
    if predictor.name == network.model.kind:
        return ""
    return (
        f"{predictor.name} predicts, because the network takes {network.model.rate:g} samples a "
        "second and the detector another number: train both together to use the network"
    )


def landmarks(model: Model) -> dict[str, float]:
    """Return the Shore A of the objects that a model was trained on, by name."""
    data = model.trained_on
    if model.windows and data.objects:
        return dict(data.objects)
    return {} if model.network is None else {f"{level:g} Shore A": level for level in data.levels}


def device_model_line(device: DevicePredictor, model: Path | None) -> str:
    """Return a line about the model that runs on a device, and how it compares with ``model``.

    ``model`` is the folder from which the device was flashed; None if the user names none.
    """
    from firstcontact.export import hand_image

    line = f"the device predicts by itself, with the model {device.model}"
    if model is None:
        return f"{line}: name the folder that it was flashed from with --model to check it"
    try:
        digest = hand_image(model).digest
    except InputError:  # the folder holds no model for a device
        digest = "another"
    if digest == device.model:
        return f"{line}, the same as in {model}: its predictions are checked"
    return f"{line}, but {model} holds {digest}: its predictions are compared, and will differ"


def device_noise(device: DevicePredictor | None) -> Calibration | None:
    """Return the noise floors that a device reports, for the host; None if it reports none."""
    from firstcontact.core import Calibration, VibrationCalibration, fingertip_layout

    if device is None or len(device.floors) < 2 or not min(device.floors) > 0:
        return None
    fingers = fingertip_layout().vibration_fingers
    pairs = zip(fingers, device.floors, strict=True)
    return Calibration(tuple(VibrationCalibration(f, noise) for f, noise in pairs))
