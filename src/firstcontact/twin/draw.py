"""Random parameters of simulated hands, specimens, sessions and pinches, and their spread.

Every hand, specimen, session and pinch has a key. Its numbers depend only on the seed and that key.
A set of pinches is therefore the same for any order and any number of workers.
"""

from __future__ import annotations

import math
import zlib
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import ArgumentError
from firstcontact.core.layout import TAXELS
from firstcontact.twin.disc import CORNERS, volts_per_newton
from firstcontact.twin.mechanics import (
    FingerParameters,
    ObjectParameters,
    Timing,
    VelostatParameters,
)
from firstcontact.twin.noise import MotorNoise, RecordedNoise
from firstcontact.twin.objects import TwinObject
from firstcontact.twin.pad import PadParameters


@dataclass(frozen=True, slots=True)
class Spread:
    """Standard deviations of a parameter's logarithm: between sessions, and between pinches."""

    session: float = 0.0
    pinch: float = 0.0


@dataclass(frozen=True, slots=True)
class Condition:
    """Named condition of the simulated hand, such as "paper-rig": the spread of its parameters."""

    name: str
    speed: Spread
    """Charge of the battery, and opening at the start."""
    tip_radius: Spread
    """Place where each fingertip touches: its radius, and by as much the pad's spring, which
    differs by 0.3 over the whole pad."""
    pad_stiffness: Spread
    """Temperature and wear of the pad."""
    phalanx_mass: Spread
    """Moving share of the finger, by its posture."""
    link_stiffness: Spread
    """Posture."""
    gain: Spread
    """Glue, disc and amplifier: the glue alone gives ± 15 %, and data sheets of discs state ± 20 %
    for the capacitance."""
    clamp: Spread
    """Hold before the grip: in a hand, or on a table."""
    noise: Spread
    """Rotor, gears and friction, by wear."""
    click_rate: float
    """Number of clicks of the gears per second."""
    mains_rates: tuple[float, ...]
    """Possible mains frequencies, Hz. Each session has one of them."""
    temperature: Spread
    """The object's modulus: warmth, first squeezes, ripening."""
    specimen_widen: float
    """Factor on the object's ``modulus_scatter``, the scatter between specimens."""
    specimens_per_block: int
    """Number of specimens of each block."""
    jitter: float
    """Standard deviation of the sampling instants, s."""
    asymmetry: float
    """Standard deviation of ln(parameter) between both fingertips: pad, phalanx, link, mount, gain,
    noise."""


PAPER_RIG = Condition(
    name="paper-rig",
    speed=Spread(0.01, 0.03),
    tip_radius=Spread(0.02, 0.06),
    pad_stiffness=Spread(0.02, 0.02),
    phalanx_mass=Spread(0.0, 0.02),
    link_stiffness=Spread(0.01, 0.03),
    gain=Spread(0.02, 0.0),
    clamp=Spread(0.10, 0.10),
    noise=Spread(0.10, 0.10),
    click_rate=0.3,
    mains_rates=(50.0,),
    temperature=Spread(0.02, 0.01),
    specimen_widen=1.0,
    specimens_per_block=1,
    jitter=2e-6,
    asymmetry=0.08,
)
EVERYDAY = Condition(
    name="everyday",
    speed=Spread(0.10, 0.20),
    tip_radius=Spread(0.05, 0.20),
    pad_stiffness=Spread(0.10, 0.05),
    phalanx_mass=Spread(0.05, 0.08),
    link_stiffness=Spread(0.05, 0.10),
    gain=Spread(0.15, 0.02),
    clamp=Spread(0.30, 0.40),
    noise=Spread(0.30, 0.30),
    click_rate=1.5,
    mains_rates=(50.0, 60.0),
    temperature=Spread(0.08, 0.03),
    specimen_widen=1.5,
    specimens_per_block=3,
    jitter=8e-6,
    asymmetry=0.15,
)
#: Conditions of simulated pinches (spread of their parameters), by name.
CONDITIONS = {c.name: c for c in (PAPER_RIG, EVERYDAY)}


def condition(name: str) -> Condition:
    if name not in CONDITIONS:
        raise ArgumentError(f"condition {name!r} is not known: use one of {', '.join(CONDITIONS)}")
    return CONDITIONS[name]


#: Mean time from the first to the second contact, s (paper).
OFFSET_MEAN = 16.65e-3
#: Standard deviation of this time, s (paper); assumed: a gamma distribution.
OFFSET_SD = 10.35e-3
#: Longest drawn time, s: a longer one does not fit into a pinch. 4 of 10,000 are longer, and are
#: drawn again.
OFFSET_MAX = 75e-3
#: Range of the first contact within a pinch, s.
FIRST_CONTACT = (0.130, 0.150)
#: Range of a sheet's conductance at 1 N, S/N^exponent [11].
CONDUCTANCE = (16e-6, 38e-6)
#: Range of a sheet's exponent [11].
EXPONENT = (0.6, 1.1)
#: Standard deviation of ln(parameter) of a sheet between two loadings: published curves scatter by
#: 9 to 27 % [11].
LOADING_SCATTER = 0.15


@dataclass(frozen=True, slots=True, eq=False)
class PinchDraw:
    """Parameters that were drawn for one pinch.

    Pairs have the index finger first, then the thumb.
    """

    fingers: tuple[FingerParameters, FingerParameters]
    object: ObjectParameters
    timing: Timing
    noise: tuple[MotorNoise, MotorNoise]
    velostat: tuple[VelostatParameters, VelostatParameters]
    shares: NDArray[np.float64]
    """Share of a finger's contact force on each of its taxels, shape (2, 6)."""
    jitter: float
    rng: np.random.Generator
    recorded: RecordedNoise | None = None
    """Recorded noise that replaces the electronics' noise and hum."""


def generator(seed: int, *key: object) -> np.random.Generator:
    """Return a random generator that depends only on ``seed`` and ``key``.

    The key names a hand, specimen, session or pinch.
    """
    words = [zlib.crc32(repr(part).encode()) for part in key]
    return np.random.default_rng([seed, *words])


def draw_specimen(seed: int, condition: Condition, kind: TwinObject, number: int) -> TwinObject:
    """Return specimen ``number`` of an object, with random properties.

    They depend only on the seed, the condition, the object and ``number``.
    """
    deviate = generator(seed, condition.name, "specimen", kind.name, number).standard_normal()
    spread = kind.modulus_scatter * condition.specimen_widen
    factor = math.exp(spread * float(np.clip(deviate, -2.5, 2.5)))
    return replace(kind, nominal=kind.nominal.stiffened(factor))


def draw_offset(rng: np.random.Generator) -> float:
    """Draw the time from the first to the second contact, s.

    Mean and standard deviation are the published ones.
    """
    shape = (OFFSET_MEAN / OFFSET_SD) ** 2
    while True:
        offset = float(rng.gamma(shape, OFFSET_MEAN / shape))
        if 0 < offset < OFFSET_MAX:
            return offset


def draw_pinch(
    seed: int, condition: Condition, session: str, kind: TwinObject, key: object
) -> PinchDraw:
    """Draw the parameters of one pinch of a specimen. ``key`` names the pinch in its session."""
    c = condition
    hand = generator(seed, c.name, "hand")
    sheet = generator(seed, c.name, "sheet")
    corners = generator(seed, c.name, "glue").uniform(*CORNERS, 2)
    day = generator(seed, c.name, "session", session)
    rng = generator(seed, c.name, "pinch", session, key)
    dimples = generator(seed, c.name, "dimples", session, key)

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
        finger_factors = np.exp(c.asymmetry * hand.standard_normal(6))
        p = FingerParameters()
        # The contact point decides the curvature of the tip, how much of the phalanx's mass moves,
        # which taxels are loaded, and which dimples carry the pad. It differs between the fingers.
        place = math.exp(c.tip_radius.pinch * rng.standard_normal())
        day_place = math.exp(c.tip_radius.session * day.standard_normal())
        pad = PadParameters().scaled(math.exp(c.tip_radius.pinch * dimples.standard_normal()))
        fingers.append(
            p._replace(
                speed=p.speed * speed * math.exp(0.01 * rng.standard_normal()),
                tip_radius=p.tip_radius * place * day_place,
                pad_stiffness=pad.stiffness * finger_factors[0] * factor("pad_stiffness"),
                pad_stiffening=pad.stiffening,
                pad_arm_stiffness=pad.arm_stiffness,
                pad_damping=pad.damping,
                phalanx_mass=p.phalanx_mass * finger_factors[1] ** 0.5 * factor("phalanx_mass"),
                link_stiffness=p.link_stiffness * finger_factors[2] * factor("link_stiffness"),
                mount_stiffness=p.mount_stiffness * finger_factors[3],
                gain=p.gain * finger_factors[4] * factor("gain"),
            )
        )
        loud = factor("noise") * finger_factors[5] * math.exp(0.05 * rng.standard_normal())
        noises.append(
            replace(MotorNoise().scaled(speed, loud), click_rate=c.click_rate, mains_rate=mains)
        )
        v = VelostatParameters()
        conductance = math.exp(sheet.uniform(*np.log(CONDUCTANCE)))
        exponent = float(sheet.uniform(*EXPONENT))
        poor = np.exp(LOADING_SCATTER * rng.standard_normal(3))
        arrays.append(
            v._replace(
                threshold=v.threshold * poor[0],
                rise=v.rise * poor[1],
                conductance=conductance * poor[2],
                exponent=exponent,
            )
        )
    hold = factor("clamp")
    o = kind.nominal.stiffened(factor("temperature"))
    held_object = o._replace(
        clamp_stiffness=o.clamp_stiffness * hold,
        clamp_damping=o.clamp_damping * hold,
    )
    first = float(rng.uniform(*FIRST_CONTACT))
    timing = Timing(first, first + draw_offset(rng), bool(rng.random() < 0.5))
    shares = rng.dirichlet(np.full(TAXELS, 25.0), 2)
    index, thumb = (
        finger._replace(piezo_volts_per_newton=volts_per_newton(share, float(corner)))
        for finger, share, corner in zip(fingers, shares, corners, strict=True)
    )
    return PinchDraw(
        (index, thumb), held_object, timing, (noises[0], noises[1]),
        (arrays[0], arrays[1]), shares, c.jitter, rng,
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
