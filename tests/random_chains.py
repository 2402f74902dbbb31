"""Random models and streams for tests of the chain."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.chain import Chain, ChainEvent, Image, build_image
from firstcontact.chain.constants import (
    Constants,
    DetectorConstants,
    DetectorKind,
    Layer,
    Matrix,
    ModelConstants,
    ProcessConstants,
    RigConstants,
    SvmConstants,
    WindowConstants,
)
from firstcontact.core import (
    Block,
    Calibration,
    Channel,
    ChannelKind,
    Finger,
    Layout,
    VibrationCalibration,
)
from firstcontact.core.layout import FINGERTIP_RATE

Array = NDArray[Any]
INPUTS, TRAITS, KNOWN, LINES, TURN = 241, 16, 15, 400, 512
#: Ranks and outputs of the network's thin layers.
RANKS, HIDDEN = (28, 30, 26, 20), (256, 256, 256, 128)
MOMENTS = (10, 15, 20, 25, 30, 35, 39, 44, 49, 54, 59, 64, 69, 74)
STAGES = (10, 15, 25, 39, 74)
FLOOR = 0.002


def random_detector(rng: np.random.Generator, kind: DetectorKind) -> DetectorConstants:
    """Return a detector of the usual sizes that fires now and then."""
    line = rng.normal(0.0, 0.6, 17)
    line[-1] = rng.normal(-2.0, 1.0)
    threshold = 3.0 if kind is DetectorKind.LOGISTIC else 6.0
    lengths = (5, 10, 20, 39, 64, 79)
    return DetectorConstants(kind, 105, 2, 197, 44, 4, lengths, threshold, 0.05, line)


def random_model(rng: np.random.Generator, pinches: int = 32, before: int = 197) -> ModelConstants:
    """Return a model of the usual sizes with random constants."""
    layers, columns = [], INPUTS
    for rank, hidden in zip(RANKS, HIDDEN, strict=True):
        into, out = _matrix(rng, rank, columns), _matrix(rng, hidden, rank)
        layers.append(Layer(into, out, rng.normal(0.0, 0.2, hidden)))
        columns = hidden
    stages = len(STAGES)
    whitening = np.tril(rng.normal(0.0, 0.2, (stages, TRAITS, TRAITS)))
    frequency = np.geomspace(60.0, FINGERTIP_RATE / 2.1, LINES) * TURN / FINGERTIP_RATE
    return ModelConstants(
        before=before,
        moments=MOMENTS,
        stages=STAGES,
        factors=rng.uniform(1.0, 2.0, stages),
        limit=rng.uniform(1.0, 20.0, stages),
        familiar=rng.normal(0.0, 1.0, (stages, TRAITS)),
        whitening=whitening,
        mean=rng.normal(0.0, 0.3, INPUTS),
        sd=rng.uniform(0.5, 2.0, INPUTS),
        layers=layers,
        answer=rng.normal(0.0, 0.15, (9, columns)),
        answer_bias=rng.normal(0.0, 0.3, 9),
        pitch_step=float(np.log(frequency[1] / frequency[0])),
        sine=np.sin(2 * np.pi * np.arange(TURN // 4 + 1) / TURN),
        fade=np.hanning(before - 10) / 1e-4,
        part=frequency % 1.0,
        cell=frequency.astype(np.int32),
        rigs=[_rig(rng, -1, pinches), _rig(rng, 0, pinches), _rig(rng, 1, 0)],
    )


def random_svms(rng: np.random.Generator, classes: tuple[float, ...] = ()) -> WindowConstants:
    """Return SVMs of two windows with random constants; the second has no interval."""
    rows = len(classes) * (len(classes) - 1) // 2 or 1
    machines = []
    for samples, vectors in ((25, 7), (74, 60)):
        shapes = rng.normal(0.0, 1.0, (vectors, samples + 1)).astype(np.float32)
        has_interval = samples == 25
        machines.append(SvmConstants(
            samples=samples, baseline=99, guard=10, least=10,
            level=-3.0, slope=2.0, gamma=0.3 / samples, mean=45.0, scale=20.0,
            vectors=shapes,
            weights=rng.normal(0.0, 1.0, (rows, vectors)),
            bias=rng.normal(0.0, 0.1, rows),
            classes=classes,
            edges=(40.0, 50.0) if has_interval else (),
            half_widths=(2.0, 1.0, 4.0) if has_interval else (),
            limits=(0.0, 100.0),
        ))  # fmt: skip
    return WindowConstants(111, (25, 74), 2, machines)


def _matrix(rng: np.random.Generator, rows: int, columns: int) -> Matrix:
    most = 60_000 // columns
    weight = rng.integers(-most, most + 1, (rows, columns))
    return Matrix(weight, rng.uniform(1.0, 3.0, rows) / (most * np.sqrt(columns)))


def _rig(rng: np.random.Generator, finger: int, pinches: int) -> RigConstants:
    stages = len(STAGES)
    process = None if pinches == 0 else ProcessConstants(
        centre=45.0,
        unit=20.0,
        mean=rng.normal(0.0, 1.0, (stages, KNOWN)),
        sd=rng.uniform(0.5, 2.0, (stages, KNOWN)),
        known=rng.normal(0.0, 1.0, (stages, KNOWN, pinches)),
        weights=rng.normal(0.0, 0.2, (stages, pinches)),
        factor=np.tril(rng.normal(0.0, 0.1, (stages, pinches, pinches))),
        scale=rng.uniform(0.8, 1.5, stages),
        offset=np.linspace(-2.0, 2.0, stages),
    )  # fmt: skip
    has_pitch = finger != 1
    return RigConstants(
        finger,
        has_level=finger != 1,
        level=float(rng.uniform(0.05, 1.0)),
        sign=float(rng.choice([-1.0, 1.0])),
        terms=rng.normal(0.0, 0.3, (stages, RANKS[1])),
        reference=rng.normal(0.0, 1.0, LINES) if has_pitch else None,
        usual_pitch=float(rng.normal(0.0, 0.05)) if has_pitch else 0.0,
        usual_speed=0.05,
        speed_spread=0.3,
        heard_error=0.2 if has_pitch else 0.0,
        process=process,
    )


#: Models of random images by their kind.
MODELS: dict[str, Callable[[np.random.Generator], Constants]] = {
    "network": random_model,
    "svr": random_svms,
    "svc": lambda rng: random_svms(rng, (10.0, 29.0, 43.0, 60.0)),
}


def random_image(
    seed: int, kind: DetectorKind = DetectorKind.LOGISTIC, model: str = "network", **options: Any
) -> Image:
    """Return a random image of the usual sizes."""
    rng = np.random.default_rng(seed)
    constants = random_detector(rng, kind), MODELS[model](rng)
    return build_image(FINGERTIP_RATE, *constants, **options)


@dataclass(frozen=True)
class Stream:
    """Random stream: pieces of samples, each with its first sample and its epoch.

    Samples have shape (n, 2 + taxels), float32, in volts.
    """

    pieces: list[tuple[int, int, Array]]
    taxels: int
    has_floors: bool
    alpha: float
    hints: tuple[float, float, float]
    floors: tuple[float, float] = field(default=(FLOOR, FLOOR))


def random_stream(rng: np.random.Generator) -> Stream:
    """Return a stream with some of these: closings, gaps, NaN, saturation, dead channels."""
    has_floors, taxels = bool(rng.random() < 0.5), int(rng.choice([0, 2]))
    n = int(rng.integers(700, 1100)) if has_floors else int(rng.integers(250, 600))
    data = rng.normal(0.0, FLOOR, (n, 2 + taxels))
    begin = int(rng.integers(200, 260)) if has_floors else 0
    motor = np.sin(np.arange(n - begin) * rng.uniform(0.2, 1.5)) * rng.uniform(0.0, 5.0)
    data[begin:, :2] += FLOOR * rng.uniform(2.0, 5.0) * (
        rng.normal(0.0, 1.0, (n - begin, 2)) + motor[:, None]
    )  # fmt: skip
    earliest = begin + (230 if has_floors else 205)
    for k in rng.permutation(2)[: rng.integers(0, 3)]:
        at = int(rng.integers(earliest, max(earliest + 1, n - 60)))
        time = np.arange(n - at)
        push = rng.choice([-1.0, 1.0]) * np.exp(rng.uniform(-4.0, 1.5)) * np.sin(
            time * rng.uniform(0.03, 0.4)
        ) * np.exp(-time / rng.uniform(5.0, 80.0))  # fmt: skip
        data[at:, k] += push[: n - at]
        data[at:, 2:] += rng.uniform(0.0, 1.0)
    faults = rng.random(5)
    if faults[0] < 0.15:
        data[rng.integers(n), rng.integers(2)] = rng.choice([np.nan, np.inf, -np.inf])
    if faults[1] < 0.15:
        np.clip(data, -0.1, 0.1, out=data)
    if faults[2] < 0.1:
        data[:, rng.integers(2)] = 0.25
    if faults[3] < 0.2:
        data = np.round(data / 1e-3) * 1e-3
    cuts = np.unique(rng.integers(1, n, rng.integers(0, 3))) if faults[4] < 0.3 else []
    pieces, first, epoch, at = [], int(rng.integers(0, 1 << 33)), 0, 0
    for end in [*cuts, n]:
        pieces.append((first, epoch, np.ascontiguousarray(data[at:end], np.float32)))
        first += int(end) - at + int(rng.choice([0, 1, 100, 5000]))
        epoch += int(rng.random() < 0.3)
        at = int(end)
    speed = float(rng.choice([0.0, 0.05, 0.3]))
    radius = float(rng.choice([np.nan, np.inf, 0.01]))
    alpha = float(rng.choice([1.0, 0.5]))
    return Stream(pieces, taxels, has_floors, alpha, (speed, 0.1, radius))


def python_events(image: Image, stream: Stream) -> list[ChainEvent]:
    """Return the events of the chain in Python."""
    finger = [Channel(f"piezo_{k}", ChannelKind.VIBRATION, f, "V") for k, f in enumerate(Finger)]
    taxel = [
        Channel(f"force_{k}", ChannelKind.FORCE, Finger.INDEX, "V", taxel=k)
        for k in range(stream.taxels)
    ]
    layout = Layout((*finger, *taxel), FINGERTIP_RATE, 1.0 if stream.alpha < 1.0 else 0.5)
    floors = zip(Finger, stream.floors, strict=True)
    calibration = Calibration(tuple(VibrationCalibration(f, x) for f, x in floors))
    chain = Chain(
        image,
        layout,
        calibration if stream.has_floors else None,
        contact=lambda sample: stream.hints,
    )
    events: list[ChainEvent] = []
    for first, epoch, data in stream.pieces:
        events += chain.take(Block(data, first, epoch))
    return events + chain.finish()
