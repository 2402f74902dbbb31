"""Model image for the hand, read by ``firmware/answers/fc_image.h``.

The image is little-endian, with every array at a multiple of 8 bytes. It begins with the magic
word, the format, and a CRC of the kernels' array lengths. It holds data only; no byte of it is
executed.
"""

from __future__ import annotations

import json
import struct
import zlib
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.contact import Detector, WindowDetector
from firstcontact.core import Calibration, InputError, digest, fingertip_layout
from firstcontact.export._c_anytime import anytime_sizes, listens
from firstcontact.export._c_detector import IMAGE_SIZES, KERNEL_SIZES, detector_sizes
from firstcontact.export._reach import check_reach
from firstcontact.models import STAGES, STILL, CompactModel, CompactNetwork, InContextModel, Rounded

MAGIC = b"FCMI"
#: Version of the format, raised when older firmware cannot read a new image.
FORMAT = 1
#: Longest description of a model, bytes: FC_IMAGE_TEXT of the firmware.
TEXT_MOST = 300
#: Order of the scalars that the detector's classifier receives.
_JUDGE = ("awake", "floor", "ridge", "bias", "doubt")


@dataclass(frozen=True, slots=True)
class ModelImage:
    """Image of a model for the hand.

    Parameters
    ----------
    data
        All bytes of the image.
    sizes
        CRC-32 of the array lengths that the kernels must have.
    digest
        Digest of the model without its noise floors, 16 hexadecimal digits.
    """

    data: bytes
    sizes: int
    digest: str


class _Writer:
    """Writer of arrays, each padded to 8 bytes."""

    def __init__(self) -> None:
        self._parts: list[bytes] = []

    def put(self, values: Any, kind: str) -> None:
        raw = np.ascontiguousarray(values, dtype=f"<{kind}").tobytes()
        self._parts.append(raw + bytes(-len(raw) % 8))

    @property
    def data(self) -> bytes:
        return b"".join(self._parts)


def model_image(
    detector: Detector, model: InContextModel, calibration: Calibration | None
) -> ModelImage:
    """Return the image of a detector and a network for a hand.

    Parameters
    ----------
    detector, model
        Detector, and model in its compact form.
    calibration
        Noise floor of each finger. Without noise floors the hand cannot detect closings: each
        stream counts as one closing.

    Raises
    ------
    InputError
        The hand's kernels do not support the structure of the detector or model.
    """
    if not isinstance(detector, WindowDetector):
        raise InputError(
            f"the detector {detector.name!r} does not judge windows, as a detector on the hand "
            "must: train another detector"
        )
    network = model.network
    if not isinstance(model, CompactModel) or not isinstance(network, CompactNetwork):
        raise InputError(
            "the network is too large for the hand: fit a smaller one with `firstcontact "
            "export-model MODEL --to hand --data RECORDINGS`, where RECORDINGS are those of the "
            "network's rig"
        )
    if listens(model):
        raise InputError(
            "this network uses the motor's pitch, which the firmware cannot compute: export the "
            "model with a smaller --budget-us, or without --budget-us"
        )
    check_reach(model, network)
    judge = detector.judgement(model.rate).constants
    if not set(_JUDGE) <= judge.keys():
        raise InputError(
            f"the firmware cannot compute the detector {detector.name!r}: train with the default "
            "--detector-type"
        )
    sizes = {
        **detector_sizes(detector, model.rate),
        **anytime_sizes(model, network),
        **KERNEL_SIZES,
    }
    floors, body = _Writer(), _Writer()
    floors.put(_floors(calibration), "f8")
    body.put([judge[name] for name in _JUDGE], "f8")
    body.put([judge["recent"]], "i4")
    body.put(judge["lengths"], "i4")
    body.put(judge["line"], "f8")
    _put_model(body, model, network)
    identity = digest(body.data)[:16]
    text = json.dumps(
        {
            "model": identity,
            "detector": detector.name,
            "anytime": model.kind,
            "floors": _floors(calibration),
        },
        separators=(",", ":"),
    ).encode()
    if len(text) > TEXT_MOST:
        raise InputError(
            f"the model's description has {len(text)} bytes, but the hand stores only "
            f"{TEXT_MOST}: train with a detector of a shorter name than {detector.name!r}"
        )
    sizes_crc = zlib.crc32(np.array([sizes[name] for name in IMAGE_SIZES], "<u4").tobytes())
    head = struct.pack("<4sIII", MAGIC, FORMAT, sizes_crc, len(text))
    data = head + text + bytes(-len(text) % 8) + floors.data + body.data
    return ModelImage(data, sizes_crc, identity)


def _floors(calibration: Calibration | None) -> list[float]:
    """Return the noise floor of each finger, V; 0 if unknown."""
    fingers = fingertip_layout().vibration_fingers
    floors = [calibration.noise(f) if calibration else None for f in fingers]
    return [0.0 if noise is None else noise for noise in floors]


def _put_model(w: _Writer, model: InContextModel, network: CompactNetwork) -> None:
    rigs = sorted(model.rigs.items(), reverse=True)
    mean, sd = network.scale("inputs")
    familiar = model.familiar
    w.put([len(rigs), model.shortest, len(STAGES)], "i4")
    w.put([STILL], "f8")
    w.put(STAGES, "i4")
    w.put(model.factors, "f8")
    w.put(familiar.mean, "f8")
    w.put(familiar.whitening, "f4")
    w.put(familiar.limit, "f8")
    w.put(mean, "f4")
    w.put((1 / sd).astype(np.float32), "f4")
    for name in ("query1", "query2", "body1", "body2", "body3"):
        layer = network.thin[name]
        _put_layer(w, layer.into)
        _put_layer(w, layer.out)
    weight, bias = network.answer
    w.put(weight.shape, "i4")
    w.put(weight, "f4")
    w.put(bias, "f4")
    for finger, rig in rigs:
        context = model.context(finger)
        along = np.array([network.along(context, s) for s in range(len(STAGES))], np.float32)
        levels = rig.tokens.shape[1]
        w.put([finger, levels], "i4")
        w.put([rig.level, rig.sign], "f8")
        w.put(along, "f4")
        w.put(context.keys, "f4")
        w.put(context.values, "f4")


def _put_layer(w: _Writer, layer: Rounded) -> None:
    rows, inputs = layer.integers.shape
    weight: NDArray[np.int16] = np.pad(layer.integers, ((0, 0), (0, -inputs % 4)))
    w.put([rows, inputs], "i4")
    w.put(weight, "i2")
    w.put(layer.scale, "f4")
    w.put(layer.bias, "f4")
