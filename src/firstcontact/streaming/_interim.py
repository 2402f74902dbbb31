# mypy: ignore-errors
# ruff: noqa
"""Stand-ins until detectors and models give their constants."""

from typing import Any

import numpy as np

from firstcontact.chain import (
    DetectorConstants,
    DetectorKind,
    Layer,
    Matrix,
    ModelConstants,
    RigConstants,
)
from firstcontact.contact import ThresholdDetector
from firstcontact.contact._logistic import AWAKE, FLOOR, LOOKS, LogisticDetector, parts


def detector_constants(detector: Any, layout: Any) -> DetectorConstants:
    rate = layout.rate
    if hasattr(detector, "constants"):
        return detector.constants(rate)
    detector.start(layout)
    sizes = detector.sizes(rate)
    lengths = sizes.window, sizes.step, sizes.steady, detector.reach * sizes.step
    if type(detector) is LogisticDetector:
        return DetectorConstants(
            DetectorKind.LOGISTIC, *lengths, LOOKS, parts(rate), AWAKE, FLOOR, detector._line
        )
    if type(detector) is ThresholdDetector:
        return DetectorConstants(DetectorKind.THRESHOLD, *lengths, threshold=detector.sigmas)
    return DetectorConstants(DetectorKind.PROGRAM, *lengths)


def network_constants(model: Any) -> tuple[Any, Any]:
    if hasattr(model, "constants"):
        return model.constants(), None
    from firstcontact.models import Touches, moments
    from firstcontact.models._touches import BEFORE
    from firstcontact.signal import samples_in

    f = np.float32
    before = samples_in(BEFORE, model.rate)

    def m(r, c):
        return Matrix(np.zeros((r, c), np.int16), np.ones(r, f))

    layers, columns = [], 241
    for _ in range(4):
        layers.append(Layer(m(4, columns), m(4, 4), np.zeros(4, f)))
        columns = 4
    n = 11
    constants = ModelConstants(
        before,
        moments(model.rate),
        (10, 12, 15, 18, 22, 26, 32, 40, 50, 61, 74),
        np.ones(n),
        np.ones(n),
        np.zeros((n, 16), f),
        np.zeros((n, 16, 16), f),
        np.zeros(241, f),
        np.ones(241, f),
        layers,
        np.zeros((9, 4), f),
        np.zeros(9, f),
        1.0,
        np.zeros(513, f),
        np.ones(before, f),
        np.zeros(400, f),
        np.zeros(400, np.int32),
        [RigConstants(-1, False, 1.0, 1.0, np.zeros((n, 4), f))],
    )

    def predict(signal, samples, finger, speed, error, radius):
        x = np.frombuffer(signal, f)[None].copy()
        t = Touches(
            signals=x,
            valid=np.array([samples]),
            fingers=np.array([finger]),
            speeds=np.array([speed or np.nan]),
            speed_errors=np.array([error if speed else np.nan]),
            radii=np.array([radius]),
            rate=model.rate,
        )
        p = model.predict(t)
        half = model.half_widths(p.spread, t.valid, model.rate)
        return (
            float(p.value[0]),
            float(p.low[0]),
            float(p.high[0]),
            float(half[0]),
            float(p.spread[0]),
            bool(p.out_of_range[0]),
        )

    return constants, predict
