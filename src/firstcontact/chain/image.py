"""Image: all constants of a detector and a model for the C chain, as one block of bytes.

``fc_image.c`` reads and checks the bytes, on the computer and on the hand. They are little-endian.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from firstcontact.chain.constants import (
    NO_DETECTOR,
    Constants,
    DetectorConstants,
    Matrix,
    ModelConstants,
    RigConstants,
    SvmConstants,
    WindowConstants,
)
from firstcontact.core import ModelError
from firstcontact.core.installation import load_compiled
from firstcontact.signal import samples_in
from firstcontact.signal.windowing import BASELINE, BASELINE_GUARD

#: Version of the format. It increases when older programs cannot read new images.
VERSION = 4
#: Longest description of a model, bytes.
TEXT_MOST = 300
#: Vibration channels of a chain.
CHANNELS_MOST = 6
#: Times in s; see ``fc_timing`` in C. A contact is withdrawn after CONFIRMED if its signal is no
#: push. The steady state is measured again every RESETTLED, in samples that are SETTLED old.
GATE_STEP, REARM = 0.003, 0.3
RESETTLED, SETTLED = 0.01, 0.008
CONFIRMED, LASTING, LAG = 0.003, 0.002, 0.0002
BEFORE_PUSH, GUARD = 0.017, 0.001
#: Shortest time for which samples stay in memory, s.
REMEMBERED = 0.1
#: Largest number of SVMs of a model.
SVMS_MOST = 8
#: Samples of the Fourier transform, and points of the spectrum.
TURN, LINES = 512, 400


@dataclass(frozen=True, eq=False)
class Image:
    """Constants of a contact detector and a model as bytes, which are checked on first use."""

    data: bytes

    @cached_property
    def handle(self) -> Any:
        """Object of the C extension that holds this image. The first access checks the bytes.

        Raises
        ------
        InputError
            The bytes are damaged or in another version of the format, or the extension is missing.
        """
        extension = chain_extension()  # its error is none of the image
        try:
            return extension.image(self.data)
        except ValueError as error:
            raise ModelError(f"{error}: train or adapt the model again") from None

    def __getstate__(self) -> dict[str, Any]:
        return {"data": self.data}


def build_image(
    rate: float,
    detector: DetectorConstants = NO_DETECTOR,
    model: Constants | None = None,
    *,
    after: float = 0.2,
    floors: Sequence[float] = (),
    text: str = "",
) -> Image:
    """Pack the constants of a detector and a model into the bytes that :class:`Chain` reads.

    Parameters
    ----------
    rate
        Sampling rate, Hz.
    detector
        Constants of the detector. By default the chain detects only closings, no contacts.
    model
        Constants of the model. By default the chain predicts no stiffness.
    after
        Time from the first contact to the end of a pinch, s.
    floors
        Noise of each vibration channel at rest, V, for the firmware. Empty if unknown.
    text
        Description of the model for the firmware, as JSON in ASCII.
    """
    w = ArrayWriter()
    w.put([rate], "f8")
    needed = 0 if model is None else model.before + model.moments[-1]
    needed += model.lookahead if isinstance(model, WindowConstants) else 0
    w.put(_timing(rate, after, detector, needed), "i4")
    d = detector
    numbers = [d.kind, d.window, d.step, d.steady, d.search, d.looks, *d.lengths, 0, 0]
    w.put(numbers, "i4")
    w.put([d.threshold, d.floor, *d.line], "f8")
    w.put([*floors, *[0.0] * (CHANNELS_MOST - len(floors))], "f8")
    raw = text.encode("ascii")
    w.put([len(raw), _model_kind(model)], "i4")
    w.put(np.frombuffer(raw, np.uint8), "u1")
    if isinstance(model, ModelConstants):
        _put_model(w, model, rate)
    elif model is not None:
        w.put([model.before, 0, 0, len(model.moments), 0, 0, 0, model.lookahead], "i4")
        w.put(np.add(model.moments, model.lookahead), "i4")
        for svm in model.svms:
            _put_svm(w, svm)
    body = w.data
    head = struct.pack("<4sIII", b"FCCH", VERSION, len(body) + 16, zlib.crc32(body))
    return Image(head + body)


def work_memory(image: Image, channels: int) -> int:
    """Return the bytes of memory that a chain with this image and number of channels needs."""
    return int(chain_extension().memory(image.handle, channels))


class ArrayWriter:
    """Writer that appends arrays to one block of bytes, each padded to a multiple of 8 bytes."""

    def __init__(self) -> None:
        self._parts: list[bytes] = []

    def put(self, values: Any, kind: str) -> None:
        raw = np.ascontiguousarray(values, dtype=f"<{kind}").tobytes()
        self._parts.append(raw + bytes(-len(raw) % 8))

    @property
    def data(self) -> bytes:
        return b"".join(self._parts)


def _model_kind(model: Constants | None) -> int:
    """Return the number for the kind of a model, as in ``fc_touch.h``; 0 for None."""
    if model is None or isinstance(model, ModelConstants):
        return int(model is not None)
    return 3 if model.svms else 2


def _timing(rate: float, after: float, detector: DetectorConstants, needed: int) -> list[int]:
    def samples(duration: float) -> int:
        return max(1, samples_in(duration, rate))

    age = samples_in(SETTLED, rate)
    longest = max(samples_in(REMEMBERED, rate), detector.steady + age, detector.window, needed) + 1
    return [
        samples(GATE_STEP),
        samples_in(REARM, rate),
        samples(RESETTLED),
        age,
        max(2, samples_in(CONFIRMED, rate)),
        samples(LASTING),
        samples(LAG),
        samples_in(BEFORE_PUSH, rate) + 1 if rate < 2 / BEFORE_PUSH else samples(BEFORE_PUSH),
        samples_in(GUARD, rate),
        samples(after),
        1 << longest.bit_length(),
        0,
    ]


def _put_model(w: ArrayWriter, m: ModelConstants, rate: float) -> None:
    baseline, guard = samples_in(BASELINE, rate), samples_in(BASELINE_GUARD, rate)
    sizes = [m.before, guard, baseline, len(m.moments), len(m.stages), len(m.rigs), len(m.fade), 0]
    w.put(sizes, "i4")
    w.put(m.moments, "i4")
    w.put(m.stages, "i4")
    w.put(m.factors, "f8")
    w.put(m.familiar, "f4")
    rows, columns = np.tril_indices(m.whitening.shape[1])
    w.put(m.whitening[:, rows, columns], "f4")
    w.put(m.limit, "f8")
    w.put([m.pitch_step], "f8")
    w.put(m.mean, "f4")
    w.put(m.sd, "f4")
    for layer in m.layers:
        _put_matrix(w, layer.into)
        _put_matrix(w, layer.out)
        w.put(layer.bias, "f4")
    w.put(m.answer, "f4")
    w.put(m.answer_bias, "f4")
    for values, kind in ((m.sine, "f4"), (m.fade, "f4"), (m.part, "f4"), (m.cell, "i4")):
        w.put(values, kind)
    for rig in m.rigs:
        _put_rig(w, rig)


def _put_svm(w: ArrayWriter, m: SvmConstants) -> None:
    vectors = m.vectors.astype(np.float64)
    edges = len(m.half_widths) - 1
    sizes = [m.guard, m.baseline, m.least, len(vectors), len(m.classes), edges, m.is_logarithmic, 0]
    w.put(sizes, "i4")
    w.put([m.level, m.slope, m.gamma, m.mean, m.scale, *m.limits], "f8")
    w.put(2.0 * m.gamma * vectors, "f4")
    w.put(-m.gamma * np.square(vectors).sum(axis=1), "f4")
    w.put(m.weights, "f4")
    w.put(m.bias, "f4")
    for values in (m.classes, m.edges, m.half_widths):
        w.put(values, "f8")


def _put_matrix(w: ArrayWriter, matrix: Matrix) -> None:
    rows, columns = matrix.weight.shape
    w.put([rows, columns], "i4")
    w.put(np.pad(matrix.weight, ((0, 0), (0, -columns % 4))), "i2")
    w.put(matrix.scale, "f4")


def _put_rig(w: ArrayWriter, r: RigConstants) -> None:
    process = r.process
    pinches = 0 if process is None else process.known.shape[2]
    w.put([r.finger, r.has_level, r.reference is not None, r.usual_speed > 0, pinches, 0], "i4")
    target = (0.0, 1.0) if process is None else (process.centre, process.unit)
    speeds = r.usual_speed, r.speed_spread, r.heard_error
    w.put([r.level, r.sign, r.usual_pitch, *speeds, *target], "f8")
    w.put(r.terms, "f4")
    if r.reference is not None:
        w.put(r.reference, "f4")
    if process is not None:
        rows, columns = np.tril_indices(pinches)
        stages = len(process.mean)
        parts = [
            process.mean,
            1.0 / process.sd,
            process.known.reshape(stages, -1),
            process.weights,
            process.factor[:, rows, columns],
            process.scale[:, None],
            process.offset[:, None],
        ]
        w.put(np.concatenate(parts, axis=1), "f4")


def chain_extension() -> Any:
    """Return the compiled module of the chain. Raise InputError if it is not installed."""
    return load_compiled("firstcontact.chain._compiled")
