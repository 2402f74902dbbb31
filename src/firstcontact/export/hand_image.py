"""Image of a model for a hand: the bytes that its firmware reads."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from firstcontact.chain import build_image
from firstcontact.chain.constants import (
    Constants,
    DetectorConstants,
    DetectorKind,
    ModelConstants,
    WindowConstants,
)
from firstcontact.chain.image import SVMS_MOST
from firstcontact.contact import Detector
from firstcontact.core import Calibration, Finger, ModelError, fingertip_layout
from firstcontact.core.quantity import SHORE_A
from firstcontact.core.weights import digest
from firstcontact.models import load_model
from firstcontact.models.anytime import Predictor

#: Kinds of detectors that C computes.
IN_C = (DetectorKind.LOGISTIC, DetectorKind.THRESHOLD)
#: Longest image that a hand stores, bytes.
CAPACITY = (1 << 18) - 16


@dataclass(frozen=True, slots=True)
class HandImage:
    """Image of a model for a hand's firmware, and the digest (hash) that identifies the model."""

    data: bytes
    digest: str


def detector_in_c(detector: Detector, rate: float) -> DetectorConstants:
    """Return the detector's constants for the C chain. Raise ModelError if it runs in Python."""
    constants = detector.chain_constants(rate)
    if constants.kind not in IN_C:
        raise ModelError(
            f"the detector {detector.name!r} cannot run in C: train with the default "
            "--detector-type"
        )
    return constants


def predictor_in_c(predictor: Predictor) -> Constants:
    """Return the predictor's constants for the C chain. Raise ModelError if it runs in Python."""
    constants = predictor.chain_constants()
    if isinstance(constants, WindowConstants) and not constants.svms:
        raise ModelError(
            f"{predictor.name} predicts in Python, so it cannot run in C: choose the network, or "
            f"at most {SVMS_MOST} SVMs of one channel, with --estimator"
        )
    return constants


def hand_image(
    folder: Path, calibration: Calibration | None = None, estimator: str | None = None
) -> HandImage:
    """Return the image of the model in ``folder`` for the firmware of a hand.

    ``calibration`` holds the noise floors of the hand's sensors, and ``estimator`` names the
    estimator to use. Raise InputError if the model cannot run on a hand, or is too large.
    """
    model, layout = load_model(folder), fingertip_layout()
    predictor, detector = model.default(estimator, layout.rate), model.own_detector
    predictor.check(layout)
    if predictor.quantity is not SHORE_A:
        raise ModelError(
            f"the model in {folder} predicts {predictor.quantity.axis}, but hands report Shore A: "
            "run it on a computer with `firstcontact live`, or in your own program with "
            "`firstcontact export-model --to c`"
        )
    model_constants = predictor_in_c(predictor)
    fingers = layout.vibration_fingers
    if isinstance(model_constants, ModelConstants):
        model_constants = _drop_other_fingers(model_constants, fingers)
    constants = detector_in_c(detector, layout.rate), model_constants
    floors = [calibration.noise(f) if calibration else None for f in fingers]
    known = [0.0 if noise is None else noise for noise in floors]
    identity = digest(build_image(layout.rate, *constants).data)[:16]
    names = {"model": identity, "detector": detector.name, "anytime": predictor.name}
    text = json.dumps(names | {"floors": known}, separators=(",", ":"))
    data = build_image(layout.rate, *constants, floors=known, text=text).data
    if len(data) > CAPACITY:
        raise ModelError(
            f"the model in {folder} has {len(data)} bytes, but a hand stores {CAPACITY}: adapt "
            "it to recordings of fewer fingers, or name a smaller one with --estimator"
        )
    return HandImage(data, identity)


def _drop_other_fingers(model: ModelConstants, fingers: Sequence[Finger | None]) -> ModelConstants:
    """Return the constants without the regressions of rigs whose finger is not in ``fingers``.

    If a finger in ``fingers`` has no rig, the rig without a finger keeps its regression.
    """
    numbers = {-1 if finger is None else list(Finger).index(finger) for finger in fingers}
    if not numbers <= {rig.finger for rig in model.rigs}:
        numbers.add(-1)
    rigs = [rig if rig.finger in numbers else replace(rig, process=None) for rig in model.rigs]
    return replace(model, rigs=rigs)
