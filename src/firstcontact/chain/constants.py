"""Constants of detectors and models, which an image stores for the C chain."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]


class DetectorKind(IntEnum):
    """Kind of a contact detector. The numbers equal those in ``fc_detector.h``."""

    NONE = 0
    LOGISTIC = 1
    THRESHOLD = 2
    #: Python judges the windows.
    PYTHON = 3


@dataclass(frozen=True, slots=True, eq=False)
class DetectorConstants:
    """Constants of a contact detector at one sampling rate, for an image.

    Lengths are in samples.
    """

    kind: DetectorKind
    window: int
    #: Distance between two windows.
    step: int
    steady: int
    #: Newest part of a window that can hold an onset.
    search: int
    #: Number of consecutive looks of a window that must agree.
    looks: int = 1
    #: Spans at the end of a look, ascending.
    lengths: Sequence[int] = (0,) * 6
    #: Deviation of a sample in sigmas: a logistic detector judges from there on, a threshold
    #: detector fires.
    threshold: float = 0.0
    #: Added to levels before their logarithm, in sigmas.
    floor: float = 1.0
    #: Weights of the features, and the intercept.
    line: Array = field(default_factory=lambda: np.zeros(17))


#: Detector of a chain that only finds closings.
NO_DETECTOR = DetectorConstants(DetectorKind.NONE, 6, 1, 6, 3)


@dataclass(frozen=True, slots=True, eq=False)
class Matrix:
    """Matrix of 16-bit integers, shape (rows, columns), with a scale for each row."""

    weight: Array
    scale: Array


@dataclass(frozen=True, slots=True, eq=False)
class Layer:
    """Layer of the network, made of two thin matrices: ``out(into(x) + rig term) + bias``."""

    into: Matrix
    out: Matrix
    bias: Array


@dataclass(frozen=True, slots=True, eq=False)
class ProcessConstants:
    """Constants of a Gaussian process that is fitted to the pinches of one rig.

    The first axis of the arrays is the signal length, called stage.
    """

    #: Mean and scale of the Shore A of the pinches.
    centre: float
    unit: float
    #: Mean and standard deviation of the inputs, shape (stages, 15).
    mean: Array
    sd: Array
    #: Standardised inputs of the pinches, shape (stages, 15, n).
    known: Array
    weights: Array
    #: Inverse of the Cholesky factor of the covariance, lower triangular.
    factor: Array
    #: Factor on the spread, and offset that is subtracted from averages, shape (stages,) each.
    scale: Array
    offset: Array


@dataclass(frozen=True, slots=True, eq=False)
class RigConstants:
    """Constants of one rig (hand or finger with its sensors) that the network is adapted to."""

    #: Number of the finger, -1 for all fingers without a rig of their own.
    finger: int
    has_level: bool
    #: Typical peak of a contact, V, and sign of its largest swing.
    level: float
    sign: float
    #: Terms that the rig adds in the network, shape (stages, rank).
    terms: Array
    #: Spectrum of the motor, shape (LINES,), and median shift of the rig's contacts.
    reference: Array | None = None
    usual_pitch: float = 0.0
    #: Median closing speed, m/s, spread of ln(speed), and error of a speed from the pitch.
    #: 0 stands for an unknown speed or error.
    usual_speed: float = 0.0
    speed_spread: float = 0.0
    heard_error: float = 0.0
    process: ProcessConstants | None = None


@dataclass(frozen=True, slots=True, eq=False)
class ModelConstants:
    """Constants of the pre-trained network and of the rigs that it is adapted to."""

    #: Samples of the signal before a contact.
    before: int
    #: Samples after the contact at which the model predicts, and at which rigs are described.
    moments: Sequence[int]
    stages: Sequence[int]
    #: Half width of an interval in spreads, and largest familiar distance, shape (stages,).
    factors: Array
    limit: Array
    #: Mean of the training's traits, shape (stages, 16), and lower triangular whitening matrices.
    familiar: Array
    whitening: Array
    #: Mean and standard deviation of the network's inputs.
    mean: Array
    sd: Array
    layers: Sequence[Layer]
    #: Last layer of the network.
    answer: Array
    answer_bias: Array
    #: Distance of two points of the spectrum in ln(frequency).
    pitch_step: float
    #: Constants of the spectrum; see ``fc_pitch`` in C.
    sine: Array
    fade: Array
    part: Array
    cell: Array
    #: One of them must be for all fingers.
    rigs: Sequence[RigConstants]


@dataclass(frozen=True, slots=True, eq=False)
class SvmConstants:
    """Constants of a support vector machine (radial basis function). Lengths are in samples."""

    samples: int
    #: Quiet signal before the contact: length, distance of its end, and shortest length.
    baseline: int
    guard: int
    least: int
    #: A window's level is (ln(RMS) - level) * slope.
    level: float
    slope: float
    gamma: float
    #: Mean and scale of the target of a regression.
    mean: float
    scale: float
    #: Support vectors, shape (vectors, samples + 1), weights (decisions, vectors), bias.
    vectors: Array
    weights: Array
    bias: Array
    #: Values of the classes; empty for a regression.
    classes: Sequence[float] = ()
    #: Predictions at which the interval's width changes, and half widths; without one, empty.
    edges: Sequence[float] = ()
    half_widths: Sequence[float] = ()
    #: Ends of the scale.
    limits: tuple[float, float] = (-1e30, 1e30)
    #: True if value and interval are natural logarithms, which the chain undoes.
    is_logarithmic: bool = False


@dataclass(frozen=True, slots=True)
class WindowConstants:
    """Constants of window models: of SVMs in C, or of models in Python that the chain calls.

    Lengths are in samples.
    """

    #: Longest signal before a contact that the model uses.
    before: int
    #: Samples after the contact that each prediction uses, ascending.
    moments: Sequence[int]
    #: Further samples that the model's filter needs.
    lookahead: int = 0
    #: Machine for each moment; empty for a model in Python.
    svms: Sequence[SvmConstants] = ()


Constants = ModelConstants | WindowConstants
