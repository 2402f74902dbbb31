"""What answers in ``firstcontact live``: the device, what was named, or what came with us."""

from __future__ import annotations

import logging
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from firstcontact.core import InputError, is_same_rate

if TYPE_CHECKING:
    from firstcontact.contact import Detector
    from firstcontact.core import Calibration
    from firstcontact.device import DevicePredictor
    from firstcontact.models import InContextModel
    from firstcontact.streaming import ModelWithInterval

#: What is said where nothing is named.
SHIPPED = (
    "no --model: the model that came with the package answers, which does not know this rig: "
    "its intervals are wide, and `firstcontact adapt` narrows them with a few pinches of blocks"
)

_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Answerers:
    """What finds contacts, what answers about them, and the objects that it knows."""

    detector: Detector | None  # None: one that needs no training
    models: list[ModelWithInterval]
    anytime: InContextModel | None
    landmarks: dict[str, float]

    @property
    def rate(self) -> float | None:
        """Rate of the samples that they take, Hz; None where any will do.

        It is that of the detector, or of the models of windows, or of the any-time model.
        """
        rates = [] if self.detector is None else [self.detector.rate]
        rates += [entry.model.spec.rate for entry in self.models]
        rates += [] if self.anytime is None else [self.anytime.rate]
        return next((rate for rate in rates if rate is not None), None)

    def at_one_rate(self) -> tuple[Answerers, str]:
        """Leave out models of another rate than :attr:`rate`. Return also a sentence about them.

        Raises
        ------
        InputError
            No model is left.
        """
        rate, left_out = self.rate, []
        models = [m for m in self.models if is_same_rate(m.model.spec.rate, rate or 0.0)]
        if len(models) < len(self.models):
            left_out.append("models of windows")
        anytime = self.anytime
        if anytime is not None and not is_same_rate(anytime.rate, rate or 0.0):
            anytime = None
            left_out.append("the any-time model")
        if not left_out:
            return self, ""
        why = (
            f"a detector or model here takes {rate:g} samples a second, and "
            f"{' and '.join(left_out)} another number"
        )
        remedy = f"train them together, with --rate {rate:g} or another"
        if not models and anytime is None:
            raise InputError(f"{why}: {remedy}")
        return replace(self, models=models, anytime=anytime), f"{why}, left out: {remedy}"


def no_model(detector: Path | None) -> Answerers:
    """No model here: the device answers by itself."""
    from firstcontact.contact import load_detector

    return Answerers(None if detector is None else load_detector(detector), [], None, {})


def whose_answers(answers: DevicePredictor, model: Path | None) -> str:
    """Whose answers these are, and what they are held against."""
    from firstcontact.export import hand_image

    told = f"the device answers by itself, with the model {answers.model}"
    if model is None:
        return f"{told}: name the folder that it was flashed from with --model to have it checked"
    try:
        own = hand_image(model).digest
    except InputError:  # no model that a hand could have
        own = "another"
    if own == answers.model:
        return f"{told}, as {model} is: its answers are checked"
    return f"{told}, and {model} is {own}: its answers are compared, and will differ"


def told_noise(answers: DevicePredictor | None) -> Calibration | None:
    """The noise above which the device hears its motor: the host is to begin closings with it."""
    from firstcontact.core import Calibration, VibrationCalibration, fingertip_layout

    if answers is None or len(answers.floors) < 2 or not min(answers.floors) > 0:
        return None
    fingers = fingertip_layout().vibration_fingers
    pairs = zip(fingers, answers.floors, strict=True)
    return Calibration(tuple(VibrationCalibration(f, noise) for f, noise in pairs))


def shipped_model(detector: Path | None) -> Answerers:
    """What came with the package."""
    from firstcontact.contact import load_detector, pretrained_detector
    from firstcontact.models import pretrained

    found = pretrained_detector() if detector is None else load_detector(detector)
    return Answerers(found, [], pretrained(), {})


def models_in(folder: Path, detector: Path | None) -> Answerers:
    """What lies in a folder: an any-time model, models of fixed windows, or both."""
    from firstcontact.contact import load_detector
    from firstcontact.models import (
        has_anytime,
        has_models,
        load_anytime,
        model_folders,
        read_anytime_card,
        read_card,
    )
    from firstcontact.streaming import ModelWithInterval

    anytime, landmarks = None, {}
    if has_anytime(folder):
        anytime = load_anytime(folder)
        levels = read_anytime_card(folder).levels
        landmarks = {f"{level:g} Shore A": level for level in levels}
        _log.info("any-time model %s: %d levels", folder, len(levels))
    folders = model_folders(folder) if anytime is None or has_models(folder) else []
    models = [ModelWithInterval.load(f) for f in folders]
    for loaded, entry in zip(folders, models, strict=True):
        _log.info("model %s: %s", loaded, entry.model.spec)
    if folders:
        landmarks = dict(read_card(folders[0]).data.objects) or landmarks
    found = load_detector(detector or (folders[0] if folders else folder))
    return Answerers(found, models, anytime, landmarks)
