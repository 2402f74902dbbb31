"""Image of a model folder for a hand that predicts by itself."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from firstcontact.chain import build_image
from firstcontact.chain.image import DetectorKind, ModelConstants, ProgramConstants
from firstcontact.core import Calibration, Finger, InputError, fingertip_layout
from firstcontact.core.weights import digest
from firstcontact.models import load_model

#: Kinds of detectors that C computes.
IN_C = (DetectorKind.LOGISTIC, DetectorKind.THRESHOLD)
#: Longest image that a hand stores, bytes.
ROOM = (1 << 18) - 16


@dataclass(frozen=True, slots=True)
class HandImage:
    """Image of a model for a hand, with the digest of the model without its noise floors."""

    data: bytes
    digest: str


def hand_image(folder: Path, calibration: Calibration | None = None) -> HandImage:
    """Return the image of a model folder for a hand."""
    model = load_model(folder)
    layout = fingertip_layout()
    if model.anytime is None:
        raise InputError(
            f"{folder}: the folder has no network: name a folder that `firstcontact adapt` wrote"
        )
    network, detector = model.anytime, model.own_detector
    model_constants = network.constants()
    if isinstance(model_constants, ProgramConstants):
        raise InputError(
            f"{folder}: {network.name} predicts in Python, so it cannot run on a hand: adapt with "
            "another estimator"
        )
    if network.rate != layout.rate:
        raise InputError(
            f"{folder}: the model needs {network.rate:g} samples a second, but a hand measures "
            f"{layout.rate:g}: adapt it to recordings of the hand"
        )
    fingers = layout.vibration_fingers
    constants = detector.constants(network.rate), _of_fingers(model_constants, fingers)
    if constants[0].kind not in IN_C:
        raise InputError(
            f"{folder}: the detector {detector.name!r} cannot run on a hand: train with the "
            "default --detector-type"
        )
    floors = [calibration.noise(f) if calibration else None for f in fingers]
    known = [0.0 if noise is None else noise for noise in floors]
    identity = digest(build_image(network.rate, *constants).data)[:16]
    text = {"model": identity, "detector": detector.name, "anytime": network.name, "floors": known}
    data = build_image(
        network.rate, *constants, floors=known, text=json.dumps(text, separators=(",", ":"))
    ).data
    if len(data) > ROOM:
        raise InputError(
            f"{folder}: the model has {len(data)} bytes, and a hand has room for {ROOM}: adapt it "
            "to recordings of fewer fingers"
        )
    return HandImage(data, identity)


def _of_fingers(model: ModelConstants, fingers: Sequence[Finger | None]) -> ModelConstants:
    """Return the constants without the largest part of a rig that none of these fingers uses."""
    numbers = {-1 if finger is None else list(Finger).index(finger) for finger in fingers}
    if not numbers <= {rig.finger for rig in model.rigs}:
        numbers.add(-1)
    rigs = [rig if rig.finger in numbers else replace(rig, process=None) for rig in model.rigs]
    return replace(model, rigs=rigs)
