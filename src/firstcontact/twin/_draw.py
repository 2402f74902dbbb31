"""Random numbers: hands, specimens, sessions and pinches, each from its own seed.

Every thing that varies has a key; its numbers depend on the seed and that key
alone, so a set is the same whatever the order or the number of workers.
"""

from __future__ import annotations

import math
import zlib
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import TAXELS
from firstcontact.twin._conditions import Condition, Spread
from firstcontact.twin._noise import MotorNoise
from firstcontact.twin._objects import TwinObject, specimen, stiffened
from firstcontact.twin._parameters import FingerParameters, ObjectParameters, Timing
from firstcontact.twin._recorded_noise import RecordedNoise
from firstcontact.twin._sensor import VelostatParameters

#: Published offset between the contacts, s: mean and standard deviation.
OFFSET_MEAN = 16.65e-3
OFFSET_SD = 10.35e-3
#: A gamma's tail reaches further than a pinch is long; this cuts 4 in 10,000.
OFFSET_MAX = 75e-3
#: The first contact falls between these instants of a pinch, s.
FIRST_CONTACT = (0.130, 0.150)


@dataclass(frozen=True, slots=True, eq=False)
class PinchDraw:
    """All that is random in one pinch; for both fingers, index first."""

    fingers: tuple[FingerParameters, FingerParameters]
    held: ObjectParameters
    timing: Timing
    noise: tuple[MotorNoise, MotorNoise]
    velostat: tuple[VelostatParameters, VelostatParameters]
    shares: NDArray[np.float64]
    """Share of the force on each taxel, shape (2, 6)."""
    jitter: float
    rng: np.random.Generator
    recorded: RecordedNoise | None = None
    """In place of the electronics' noise and hum."""


def generator(seed: int, *key: object) -> np.random.Generator:
    """A generator of its own for whatever ``key`` names."""
    words = [zlib.crc32(repr(part).encode()) for part in key]
    return np.random.default_rng([seed, *words])


def draw_specimen(seed: int, condition: Condition, kind: TwinObject, number: int) -> TwinObject:
    """The ``number``-th specimen of a kind of object."""
    deviate = generator(seed, condition.name, "specimen", kind.name, number).standard_normal()
    return specimen(kind, float(np.clip(deviate, -2.5, 2.5)), condition.specimen_widen)


def draw_offset(rng: np.random.Generator) -> float:
    """Offset between the contacts, s: the gamma with the published mean and SD."""
    shape = (OFFSET_MEAN / OFFSET_SD) ** 2
    while True:
        offset = float(rng.gamma(shape, OFFSET_MEAN / shape))
        if 0 < offset < OFFSET_MAX:
            return offset


def draw_pinch(
    seed: int, condition: Condition, session: str, kind: TwinObject, key: object
) -> PinchDraw:
    """One pinch of a specimen in a session; ``key`` tells it from the others there."""
    c = condition
    hand = generator(seed, c.name, "hand")
    day = generator(seed, c.name, "session", session)
    rng = generator(seed, c.name, "pinch", session, key)

    day_factor = {name: float(day.standard_normal()) for name in _SPREADS}
    now_factor = {name: float(rng.standard_normal()) for name in _SPREADS}

    def factor(name: str) -> float:
        spread: Spread = getattr(c, name)
        return math.exp(spread.session * day_factor[name] + spread.pinch * now_factor[name])

    speed = factor("speed")
    fingers = []
    noises = []
    arrays = []
    mains = float(day.choice(c.mains_rates))
    for _ in range(2):
        own = np.exp(c.asymmetry * hand.standard_normal(6))
        p = FingerParameters()
        # Where the tip touches decides its curvature, its share of the phalanx
        # and which taxels are under it; that differs between the two fingers.
        place = math.exp(c.tip_radius.pinch * rng.standard_normal())
        day_place = math.exp(c.tip_radius.session * day.standard_normal())
        fingers.append(
            p._replace(
                speed=p.speed * speed * math.exp(0.01 * rng.standard_normal()),
                tip_radius=p.tip_radius * place * day_place,
                pad_stiffness=p.pad_stiffness * own[0] * factor("pad_stiffness"),
                phalanx_mass=p.phalanx_mass * own[1] ** 0.5 * factor("phalanx_mass"),
                link_stiffness=p.link_stiffness * own[2] * factor("link_stiffness"),
                mount_stiffness=p.mount_stiffness * own[3],
                gain=p.gain * own[4] * factor("gain"),
            )
        )
        loud = factor("noise") * own[5] * math.exp(0.05 * rng.standard_normal())
        noises.append(
            replace(MotorNoise().scaled(speed, loud), click_rate=c.click_rate, mains_rate=mains)
        )
        v = VelostatParameters()
        # Velostat repeats poorly: tens of per cent between loadings.
        poor = np.exp(0.15 * rng.standard_normal(3))
        arrays.append(
            v._replace(
                threshold=v.threshold * poor[0],
                rise=v.rise * poor[1],
                conductance=v.conductance * poor[2],
            )
        )
    hold = factor("clamp")
    o = stiffened(kind.nominal, factor("temperature"))
    held = o._replace(
        clamp_stiffness=o.clamp_stiffness * hold,
        clamp_damping=o.clamp_damping * hold,
    )
    first = float(rng.uniform(*FIRST_CONTACT))
    timing = Timing(first, first + draw_offset(rng), bool(rng.random() < 0.5))
    shares = rng.dirichlet(np.full(TAXELS, 25.0), 2)
    return PinchDraw(
        (fingers[0], fingers[1]), held, timing, (noises[0], noises[1]), (arrays[0], arrays[1]),
        shares, c.jitter, rng,
    )  # fmt: skip


_SPREADS = (
    "speed",
    "pad_stiffness",
    "phalanx_mass",
    "link_stiffness",
    "gain",
    "clamp",
    "noise",
    "temperature",
)
