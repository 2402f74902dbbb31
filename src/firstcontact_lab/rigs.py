"""Random simulated rigs and objects, to pre-train a network that suits any rig.

A rig is a hand with its sensors and closing speed. The distribution of rigs is wide, and its centre
differs from the twin. The limits of the distribution come from mechanics and electronics. No limit
was tuned on a score. Each of the :data:`FAMILIES` differs from these rigs or objects in its
structure, not only in random numbers. Networks are tested on the families, but never trained on
them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from firstcontact.core.layout import FINGERTIP_RATE
from firstcontact.core.physics import gent_modulus
from firstcontact.twin.mechanics import FingerParameters, ObjectParameters
from firstcontact.twin.noise import MotorNoise
from firstcontact.twin.objects import shell_stiffness, slow_share
from firstcontact.twin.pad import confinement
from firstcontact.twin.pinch import piezo_samples, touch_voltage

SOFTEST, HARDEST = 5.0, 80.0
#: Hand at the centre of the distribution. Each parameter is about one standard deviation from the
#: twin's. The pad is as stiff as all its dimples together; ``DIMPLED`` and ``BACKED`` follow.
MIDDLE = FingerParameters()._replace(
    speed=0.105,
    drive_mass=0.35,
    speed_gain=300.0,
    link_stiffness=3.1e3,
    link_damping=2.4,
    phalanx_mass=0.0215,
    mount_stiffness=3.4e5,
    mount_damping=3.3,
    board_mass=0.0025,
    pad_stiffness=3.7e4,
    pad_stiffening=8.5e11,
    pad_arm_stiffness=2.7e4,
    pad_relaxation=0.95e-3,
    pad_damping=1.9,
    skin_mass=0.00045,
    pad_modulus=3.8e6,
    tip_radius=0.0116,
    piezo_time_constant=3.6e-3,
    buffer_cutoff=1.5e3,
)
RIG_SPREAD: Mapping[str, float] = {
    "speed": 0.35,
    "drive_mass": 0.25,
    "speed_gain": 0.20,
    "link_stiffness": 0.25,
    "link_damping": 0.25,
    "phalanx_mass": 0.20,
    "mount_stiffness": 0.25,
    "mount_damping": 0.30,
    "board_mass": 0.20,
    "pad_stiffness": 0.22,
    "pad_stiffening": 0.45,
    "pad_arm_stiffness": 0.25,
    "pad_relaxation": 0.30,
    "pad_damping": 0.25,
    "skin_mass": 0.25,
    "pad_modulus": 0.18,
    "tip_radius": 0.18,
    "piezo_time_constant": 0.30,
    "buffer_cutoff": 0.20,
}
#: Standard deviations of ln(parameter) between the sessions of a rig, and between the pinches of a
#: session. They describe a rig with everyday repeatability. Each rig multiplies them by a factor.
SESSION_SPREAD: Mapping[str, float] = {
    "speed": 0.10, "tip_radius": 0.05, "pad_stiffness": 0.10, "phalanx_mass": 0.05,
    "link_stiffness": 0.05, "gain": 0.10, "clamp": 0.30, "noise": 0.30, "modulus": 0.08,
}  # fmt: skip
PINCH_SPREAD: Mapping[str, float] = {
    "speed": 0.15, "tip_radius": 0.17, "pad_stiffness": 0.17, "phalanx_mass": 0.08,
    "link_stiffness": 0.10, "gain": 0.02, "clamp": 0.40, "noise": 0.30, "modulus": 0.03,
}  # fmt: skip
#: Parameters of the pad's spring, and its share in a touch: of a pad on dimples, and of one on a
#: stiff back, which also confines the contact. One rig in four has a stiff back.
PAD = ("pad_stiffness", "pad_stiffening", "pad_arm_stiffness", "pad_damping")
DIMPLED, BACKED, BACK = (0.2, 1.0), (1.0, 4.0), 0.25
#: Largest slow arm of a block, and largest loss factor of an object over seconds. That is at most
#: the loss factor within milliseconds: equal ones lose alike at all frequencies.
BLOCK_SLOW, OBJECT_SLOW = 0.1, 0.35
#: Wall of a hollow object relative to its radius, and the factor on its stiffness against a dent:
#: pressure, felt, and walls that are no part of a sphere. Walls of ``thin_shell`` are thinner.
WALL, DENTED = (0.12, 0.4), (0.5, 2.0)
THIN_WALL = (0.04, 0.08)
#: Smallest and largest factor by which a rig multiplies these standard deviations.
REPEATS = (0.15, 1.5)
#: Range of the peak-to-peak voltage of a hard block at the converter. The gain of each rig is set
#: so that its voltage is in this range.
PEAK = (0.12, 2.2)
#: Standard deviation of ln(modulus) between specimens of a block, and its range for other objects.
BLOCK_SCATTER = 0.06
SCATTER = (0.03, 0.25)

Rng = np.random.Generator


@dataclass(frozen=True, slots=True)
class Resonance:
    """Ringing of the part that holds the piezo disc: frequency (Hz), damping ratio and strength."""

    frequency: float
    damping: float
    strength: float

    def apply(self, volts: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the voltage, shape (samples,), with the ringing added."""
        from scipy.signal import lfilter  # slow to import, and only some rigs need it

        turn = 2 * math.pi * self.frequency / FINGERTIP_RATE
        radius = math.exp(-self.damping * turn)
        swing = 2 * radius * math.cos(turn * math.sqrt(1 - self.damping**2))
        gain = 1.5 * (1 - radius)
        ringing = lfilter([gain, -0.98 * gain], [1.0, -swing, radius * radius], volts)
        out: NDArray[np.float64] = volts + self.strength * ringing
        return out


@dataclass(frozen=True, slots=True)
class RandomRig:
    """Simulated hand with random parameters. Only one of its fingertips is simulated."""

    finger: FingerParameters
    noise: MotorNoise
    #: Standard deviations of ln(parameter) between sessions and between pinches.
    session: Mapping[str, float]
    pinch: Mapping[str, float]
    #: Standard deviation of ln(modulus) between the specimens of a block.
    block_scatter: float
    resonance: Resonance | None
    #: Standard deviation of the sampling instants, s.
    jitter: float


@dataclass(frozen=True, slots=True)
class RandomObject:
    shore_a: float
    parameters: ObjectParameters


Day = Mapping[str, float]


def draw_rig(rng: Rng) -> RandomRig:
    """Return a random simulated hand. Its gain suits the signals of hard blocks."""
    finger = MIDDLE._replace(
        **{name: getattr(MIDDLE, name) * _lognormal(rng, sd) for name, sd in RIG_SPREAD.items()}
    )
    if rng.random() < BACK:
        back = confinement(finger.pad_modulus, float(rng.uniform(2e-3, 4e-3)))
        finger = finger._replace(pad_confinement=back * float(rng.uniform(0.3, 1.0)))
        finger = _scale_pad(finger, _between(rng, *BACKED))
    else:
        finger = _scale_pad(finger, _between(rng, *DIMPLED))
    m = MotorNoise()
    loud = _lognormal(rng, 0.3)
    noise = replace(
        m,
        rotor_rate=_between(rng, 60.0, 400.0),
        rotor=m.rotor * loud * _lognormal(rng, 0.4),
        mesh_ratio=_between(rng, 3.0, 20.0),
        mesh=m.mesh * loud * _lognormal(rng, 0.4),
        friction=m.friction * loud * _lognormal(rng, 0.3),
        click_rate=float(rng.uniform(0.0, 2.0)),
        mains_rate=float(rng.choice([50.0, 60.0])),
        mains=m.mains * _lognormal(rng, 0.4),
        hum=m.hum * _lognormal(rng, 0.4),
        electronics=m.electronics * _lognormal(rng, 0.25),
    )
    repeats = rng.uniform(*REPEATS)
    landing = repeats * rng.uniform(0.4, 1.3)
    pinch = {name: repeats * sd for name, sd in PINCH_SPREAD.items()}
    for name in ("tip_radius", "pad_stiffness"):  # by the place of the touch
        pinch[name] = PINCH_SPREAD[name] * landing
    resonance = None
    if rng.random() < 0.3:
        strength = float(rng.uniform(0.1, 0.8) * rng.choice([-1.0, 1.0]))
        resonance = Resonance(_between(rng, 300.0, 2300.0), _between(rng, 0.05, 0.5), strength)
    rig = RandomRig(
        finger, noise, {name: repeats * sd for name, sd in SESSION_SPREAD.items()}, pinch,
        BLOCK_SCATTER * rng.uniform(0.5, 1.6), resonance, _between(rng, 1e-6, 1e-5),
    )  # fmt: skip
    return with_random_gain(rig, rng)


def with_random_gain(rig: RandomRig, rng: Rng) -> RandomRig:
    """Return the rig with a random gain, so that the peak of a hard block lies within ``PEAK``."""
    quiet = replace(
        rig,
        finger=rig.finger._replace(gain=1.0),
        session=dict.fromkeys(rig.session, 0.0),
        pinch=dict.fromkeys(rig.pinch, 0.0),
    )
    block = RandomObject(60.0, _block(60.0, 0.07, 0.035, 1100.0, 0.12))
    volts, _ = touch_volts(quiet, draw_day(rng), block, rng, 0.005, 0.015)
    return replace(rig, finger=rig.finger._replace(gain=_between(rng, *PEAK) / np.ptp(volts)))


def draw_day(rng: Rng) -> Day:
    """Return random deviations of the rig's parameters in one session, in standard deviations."""
    return {name: float(rng.standard_normal()) for name in SESSION_SPREAD}


def draw_block(rng: Rng, shore_a: float, scatter: float) -> RandomObject:
    """Return a random flat block of hardness ``shore_a``.

    ``scatter`` is the standard deviation of the logarithm of the block's modulus.
    """
    side, height = _between(rng, 0.04, 0.10), _between(rng, 0.02, 0.06)
    block = _block(
        shore_a, side, height, float(rng.uniform(1000, 1300)), float(rng.uniform(0.05, 0.2))
    )
    block = block._replace(clamp_stiffness=_between(rng, 30, 400))
    block = block._replace(slow_share=float(rng.uniform(0.0, BLOCK_SLOW)))
    return RandomObject(
        shore_a, _with_random_relaxation(rng, block).stiffened(_scattered(rng, scatter))
    )


def draw_object(rng: Rng) -> RandomObject:
    shore_a = float(rng.uniform(SOFTEST, HARDEST))
    modulus = gent_modulus(shore_a)
    loss = _between(rng, 0.05, 0.6)
    slow, dent = slow_share(min(loss * rng.uniform(), OBJECT_SLOW)), math.inf
    kind = rng.choice(4, p=[0.25, 0.45, 0.15, 0.15])
    if kind == 0:  # flat
        side, height = _between(rng, 0.02, 0.12), _between(rng, 0.01, 0.08)
        target = _block(shore_a, side, height, float(rng.uniform(500, 1500)), loss, slow)
    else:
        if kind == 1:  # solid and round
            radius = _between(rng, 0.008, 0.06)
            mass = 4 / 3 * math.pi * radius**3 * rng.uniform(500, 1200) * _between(rng, 0.7, 1.6)
            bulk = modulus * math.pi * radius / 2 * _between(rng, 0.7, 1.4)
        elif kind == 2:  # hollow: each contact dents its wall
            radius, mass = _between(rng, 0.012, 0.06), _between(rng, 0.01, 0.6)
            bulk = modulus * math.pi * radius / 2
            dent = shell_stiffness(modulus, radius, radius * _between(rng, *WALL))
            dent *= (1 + 2 * loss) * _between(rng, *DENTED)
        else:  # any radius, mass and stiffness
            radius, mass = _between(rng, 0.005, 0.2), _between(rng, 0.01, 0.6)
            bulk = _between(rng, 3e3, 1e6)
        target = ObjectParameters.solid(shore_a, float(mass), float(bulk), loss, slow)._replace(
            radius=radius, dent_stiffness=dent
        )
    target = target._replace(
        clamp_stiffness=_between(rng, 15, 400), clamp_damping=_between(rng, 0.2, 4.0),
        face_mass=max(target.face_mass, 0.004),
    )  # fmt: skip
    scatter = float(rng.uniform(*SCATTER))
    return RandomObject(
        shore_a, _with_random_relaxation(rng, target).stiffened(_scattered(rng, scatter))
    )


def touch(
    rig: RandomRig, day: Day, target: RandomObject, rng: Rng, lead: float, tail: float
) -> tuple[NDArray[np.int16], float]:
    """Simulate one contact. Return (signal in 1/32 ADC counts, closing speed in m/s).

    The signal begins ``lead`` s before the contact and ends ``tail`` s after it.
    """
    volts, speed = touch_volts(rig, day, target, rng, lead, tail)
    return piezo_samples(volts), speed


def touch_volts(
    rig: RandomRig, day: Day, target: RandomObject, rng: Rng, lead: float, tail: float
) -> tuple[NDArray[np.float64], float]:
    def factor(name: str) -> float:
        return math.exp(rig.session[name] * day[name] + rig.pinch[name] * rng.standard_normal())

    f = rig.finger
    speed = factor("speed")
    finger = _scale_pad(f, factor("pad_stiffness"))._replace(
        speed=f.speed * speed,
        **{
            name: getattr(f, name) * factor(name)
            for name in ("tip_radius", "phalanx_mass", "link_stiffness", "gain")
        },
    )
    m = rig.noise
    noise = m.scaled(speed, factor("noise"))
    o = target.parameters.stiffened(factor("modulus"))
    hold = factor("clamp")
    o = o._replace(clamp_stiffness=o.clamp_stiffness * hold, clamp_damping=o.clamp_damping * hold)
    volts = touch_voltage(finger, o, noise, rig.jitter, lead, tail, rng)
    if rig.resonance is not None:
        volts = rig.resonance.apply(volts)
    return volts, float(finger.speed)


def _lognormal(rng: Rng, spread: float) -> float:
    return math.exp(spread * rng.standard_normal())


def _between(rng: Rng, least: float, most: float) -> float:
    return math.exp(rng.uniform(math.log(least), math.log(most)))


def _scattered(rng: Rng, scatter: float) -> float:
    return math.exp(scatter * float(np.clip(rng.standard_normal(), -2.5, 2.5)))


def _scale_pad(finger: FingerParameters, factor: float) -> FingerParameters:
    """Return the finger with the stiffness and damping of its pad multiplied by ``factor``."""
    return finger._replace(**{name: getattr(finger, name) * factor for name in PAD})


def _block(
    shore_a: float, side: float, height: float, density: float, loss: float, slow: float = 0.0
) -> ObjectParameters:
    bulk = gent_modulus(shore_a) * side * side / height
    return ObjectParameters.solid(shore_a, side * side * height * density, bulk, loss, slow)


def _with_random_relaxation(rng: Rng, target: ObjectParameters) -> ObjectParameters:
    """Return the object with random time constants and strengths of its material's relaxation."""
    return target._replace(
        arm_share=target.arm_share * _between(rng, 0.75, 1.33),
        arm_relaxation=_between(rng, 2.5e-3, 6.4e-3),
        slow_relaxation=_between(rng, 0.05, 0.2),
    )


@dataclass(frozen=True, slots=True)
class Family:
    title: str
    rig: Callable[[RandomRig, Rng], RandomRig] = lambda rig, rng: rig
    change_object: Callable[[RandomObject, Rng], RandomObject] = lambda target, rng: target


def _linear_pad(rig: RandomRig, rng: Rng) -> RandomRig:
    finger = rig.finger._replace(pad_stiffening=0.0, pad_arm_stiffness=0.0)
    return with_random_gain(replace(rig, finger=finger), rng)


def _duller_sensor(rig: RandomRig, rng: Rng) -> RandomRig:
    # A second resonance of the board, high and lightly damped, behind a slow buffer amplifier.
    resonance = Resonance(float(rng.uniform(1500, 2300)), 0.02, float(rng.uniform(0.8, 1.5)))
    finger = rig.finger._replace(buffer_cutoff=float(rng.uniform(400, 700)))
    return with_random_gain(replace(rig, finger=finger, resonance=resonance), rng)


def _silent_motor(rig: RandomRig, rng: Rng) -> RandomRig:
    noise = replace(rig.noise, rotor=0.0, mesh=0.0, friction=2 * rig.noise.friction)
    return replace(rig, noise=noise)


def _slow_closing(rig: RandomRig, rng: Rng) -> RandomRig:
    return with_random_gain(
        replace(rig, finger=rig.finger._replace(speed=float(rng.uniform(0.02, 0.04)))), rng
    )


def _edge(target: RandomObject, rng: Rng) -> RandomObject:
    radius = float(np.exp(rng.uniform(np.log(1.5e-3), np.log(4e-3))))
    return replace(target, parameters=target.parameters._replace(radius=radius))


def _thin_shell(target: RandomObject, rng: Rng) -> RandomObject:
    o, radius, thin = target.parameters, float(rng.uniform(0.02, 0.05)), _between(rng, *THIN_WALL)
    dent = (1 + o.arm_share) * shell_stiffness(o.modulus, radius, radius * thin)
    mass = 4 * math.pi * radius**3 * thin * float(rng.uniform(900, 1300))
    shell = o._replace(dent_stiffness=dent, radius=radius, face_mass=max(mass / 2, 0.004))
    return replace(target, parameters=shell)


def _slow_material(target: RandomObject, rng: Rng) -> RandomObject:
    relaxation = float(rng.uniform(0.012, 0.04))
    return replace(target, parameters=target.parameters._replace(arm_relaxation=relaxation))


FAMILIES: Mapping[str, Family] = {
    "linear_pad": Family("a pad that does not stiffen", rig=_linear_pad),
    "duller_sensor": Family("a slow buffer and a second board mode", rig=_duller_sensor),
    "silent_motor": Family("a motor without lines", rig=_silent_motor),
    "slow_closing": Family("closing at 20 to 40 mm/s", rig=_slow_closing),
    "edge": Family("edges of 1.5 to 4 mm", change_object=_edge),
    "thin_shell": Family("hollow, with walls of 4 to 8 % of the radius", change_object=_thin_shell),
    "slow_material": Family("relaxation in 12 to 40 ms", change_object=_slow_material),
}
