"""Random streams with gaps, epochs, lost and constant samples, saturation, loads and contacts."""

from dataclasses import dataclass

import numpy as np
from detection_reference import Stream, Stretch
from numpy.typing import NDArray

from firstcontact.chain import Chain, build_image
from firstcontact.chain.constants import DetectorConstants, DetectorKind
from firstcontact.core import (
    Block,
    Calibration,
    Channel,
    ChannelKind,
    Finger,
    Layout,
    VibrationCalibration,
)

#: Weights of a trained logistic detector, rounded.
LINE = np.array(
    [-0.6, 0.1, 0.5, 1.1, 0.4, -0.3, -0.3, 1.2, -0.5, 0.4, 0.6, 1.0, 0.3, -0.2, -0.2, 1.0, -6.0]
)
#: Scale of raw samples, V.
VOLT = 2.0**-14


@dataclass(frozen=True)
class RandomStream:
    """Random stream, and the settings of chain and reference."""

    stream: Stream
    layout: Layout
    calibration: Calibration | None
    blocks: tuple[Block, ...]

    def chain(self, **options: object) -> Chain:
        """Return a new chain."""
        s = self.stream
        image = build_image(s.rate, s.constants, after=s.after)
        return Chain(
            image,
            self.layout,
            self.calibration,
            keeps_first_state=s.keeps_first_state,
            **options,  # type: ignore[arg-type]
        )

    @property
    def stretches(self) -> list[Stretch]:
        """The same samples in V."""
        columns = self.layout.columns(ChannelKind.VIBRATION)
        loads = self.layout.columns(ChannelKind.FORCE)
        scale = np.array([c.scale for c in self.layout.column_channels])
        offset = np.array([c.offset for c in self.layout.column_channels])
        return [
            Stretch(b.first_sample, b.epoch, volts[:, columns], volts[:, loads])
            for b in self.blocks
            for volts in [(b.data - offset) * scale]
        ]


def random_stream(seed: int) -> RandomStream:
    """Return a stream of some seconds at a low rate."""
    rng = np.random.default_rng(seed)
    rate = float(rng.choice([400.0, 700.0, 1000.0]))
    fingers: list[Finger | None] = list(list(Finger)[: rng.integers(1, 3)])
    if rng.random() < 0.2:
        fingers[-1] = None
    taxels = int(rng.integers(0, 3))
    is_raw = rng.random(len(fingers)) < 0.5
    offset = float(rng.choice([0.0, 16384.0]))
    vibration = tuple(
        Channel(
            f"v{k}",
            ChannelKind.VIBRATION,
            f,
            "V",
            VOLT,
            offset,
            smoothing_alpha=1.0 if is_raw[k] else 0.5,
        )
        for k, f in enumerate(fingers)
    )
    force = tuple(Channel(f"f{k}", ChannelKind.FORCE, None, "V", VOLT) for k in range(taxels))
    order = rng.permutation(len(vibration) + taxels)
    layout = Layout(tuple((*vibration, *force)[k] for k in order), rate)
    floor = float(rng.choice([0.002, 0.01]))
    floors = None
    if rng.random() < 0.75:
        floors = np.full(len(fingers), floor)
    calibration = None
    if floors is not None:
        calibration = Calibration(tuple(VibrationCalibration(f, floor) for f in fingers))
    columns = layout.columns(ChannelKind.VIBRATION)
    stream = Stream(
        rate,
        _constants(rng, rate),
        np.array([0.5 if layout.channels[c].smoothing_alpha == 1.0 else 1.0 for c in columns]),
        floors,
        None in fingers,
        bool(rng.random() < 0.2),
        float(rng.choice([0.02, 0.2, 1000.0])),
    )
    return RandomStream(stream, layout, calibration, tuple(_blocks(rng, layout, floor)))


def _constants(rng: np.random.Generator, rate: float) -> DetectorConstants:
    steady = int(rng.integers(30, 50))
    threshold, step = float(rng.choice([3.0, 5.0, 10.0])), int(rng.integers(1, 4))
    if rng.random() < 0.5:
        window = int(rng.integers(max(6, step), steady))
        return DetectorConstants(
            DetectorKind.THRESHOLD, window, step, steady, 3 * step, threshold=threshold
        )
    line = LINE + 0.2 * rng.standard_normal(17)
    looks, lengths = int(rng.integers(1, 5)), [1, 2, 3, 4, 5, 8]
    window = lengths[-1] + 13 + int(rng.integers(0, 8)) + (looks - 1) * step
    return DetectorConstants(
        DetectorKind.LOGISTIC,
        window,
        step,
        max(steady, window),
        3 * step + 4,
        looks,
        lengths,
        threshold,
        0.1,
        line,
    )


def _blocks(rng: np.random.Generator, layout: Layout, floor: float) -> list[Block]:
    """Return samples of phases of rest, motor and contacts, with one block for each stretch."""
    columns = layout.columns(ChannelKind.VIBRATION)
    loads = layout.columns(ChannelKind.FORCE)
    phases: list[NDArray[np.float64]] = []
    for _ in range(int(rng.integers(3, 8))):
        n = int(rng.integers(10, int(0.2 * layout.rate)))
        x = np.zeros((n, layout.width))
        loudness = floor * rng.choice([0.5, 0.9, 1.5, 2.5, 6.0])
        noise = loudness * rng.standard_normal((n, len(columns)))
        kind = rng.random()
        if kind < 0.1:
            noise[:, rng.integers(len(columns))] = 0.0
        elif kind < 0.7 and n > 20:
            k = rng.integers(len(columns))
            age = np.arange(n - n // 2)
            decay, pitch = rng.choice([0.5, 3.0, 40.0]), rng.choice([0.1, 0.5, 2.5])
            peak = floor * rng.choice([20.0, 100.0, 1000.0])
            for c, late in ((k, 0), (1 - k, int(rng.integers(0, 9)))):
                if 0 <= c < len(columns):
                    ring = peak * np.exp(-age / decay) * np.cos(pitch * age)
                    noise[n // 2 + late :, c] += ring[: len(ring) - late]
        x[:, columns] = noise
        x[:, loads] = rng.choice([0.1, 1.0]) + 0.01 * rng.standard_normal((n, len(loads)))
        phases.append(x)
    volts = np.concatenate(phases)
    offset = np.array([c.offset for c in layout.channels])
    data = volts / VOLT + offset
    if rng.random() < 0.3:  # saturation
        data = np.clip(data, offset - 10 * floor / VOLT, offset + 10 * floor / VOLT)
    if rng.random() < 0.6:
        data = np.clip(np.rint(data), -32768, 32767).astype(np.int16)
    elif rng.random() < 0.6:
        data[rng.integers(len(data), size=3), rng.integers(len(columns))] = np.nan
    cuts = np.sort(rng.integers(0, len(data), rng.integers(0, 4)))
    first, epoch, out = int(rng.choice([0, 17, 10**9])), 0, []
    for piece in np.split(data, cuts):
        if not len(piece):
            continue
        out.append(Block(piece, first, epoch))
        first += len(piece)
        if rng.random() < 0.5:
            first += int(rng.integers(1, 60))
        else:
            epoch, first = epoch + 1, int(rng.choice([first, 0]))
    return out
