"""Remarks of ``firstcontact live`` on the model that predicts, and facts from it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from firstcontact.core import InputError, is_same_rate

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


def who_predicts(model: Model, predictor: Predictor, estimator: str | None) -> str:
    """Return a note that names the estimator that predicts, and the model's others."""
    default = model.predictors[0]
    fitting = [p.name for p in model.predictors if is_same_rate(p.rate, predictor.rate)]
    others = [name for name in dict.fromkeys(fitting) if name != predictor.name]
    if estimator is None and default.name != predictor.name:
        return (
            f"{predictor.name} predicts, because {default.name} takes {default.rate:g} samples a "
            f"second and the detector another number: train both together to use {default.name}"
        )
    choice = f"; to change that, add --estimator {' or '.join(others)}" if others else ""
    return f"{predictor.name} predicts{choice}"


def landmarks(model: Model) -> dict[str, float]:
    """Return the Shore A of the objects that a model was trained on, by name."""
    data = model.trained_on
    if model.windows and data.objects:
        return dict(data.objects)
    return {} if model.network is None else {f"{level:g} Shore A": level for level in data.levels}


def device_model_line(device: DevicePredictor, model: Path | None) -> str:
    """Return a line about the model that runs on a device, and how it compares with ``model``."""
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
