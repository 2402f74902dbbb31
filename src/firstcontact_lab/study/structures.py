"""Simulated closings of rigs that differ from the twin in motor, noise, start and contact.

The study part ``structure`` uses them. The twin simulates only the mechanics of the contact, with a
silent motor and parameters outside the training range. This module makes all other parts of the
signals. No model is trained on these closings.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import (
    Calibration,
    Contact,
    Dataset,
    Finger,
    Label,
    Pinch,
    Role,
    VibrationCalibration,
    fingertip_layout,
)
from firstcontact.core.layout import FINGERTIP_RATE, PIEZO_OFFSET_VOLTS
from firstcontact.twin import BLOCKS, CONDITIONS, draw_pinch
from firstcontact.twin.draw import generator
from firstcontact.twin.mechanics import BUFFER
from firstcontact.twin.pinch import excerpt, integrate_pinch
from firstcontact_lab.rigs import RandomObject, RandomRig, Rng, draw_block, draw_object, draw_rig

Values = NDArray[np.float64]
#: Times of a closing, s: rest before the motor starts, free closing (range), and after the contact.
REST = 0.2
FREE = (0.15, 0.6)
AFTER = 0.15
#: Time before a contact from which the mechanics are simulated, s.
LEAD = 0.012
#: Standard deviation of the labels of objects, Shore A.
LABEL = 2.0
#: Range of the ratio between the peak of a hard block and the RMS of the motor.
CLEAR = (80.0, 400.0)
#: Clicks and swells of all motors: largest number of each per second, median peak of a click, and
#: largest growth of a swell. Peak and growth are multiples of the motor's RMS.
CLICKS, CLICK = 2.0, 10.0
SWELLS, SWELL = 0.5, 3.0


def _white(rng: Rng, n: int) -> Values:
    return rng.standard_normal(n)


def _pink(rng: Rng, n: int) -> Values:
    spectrum = np.fft.rfft(rng.standard_normal(n))
    spectrum /= np.sqrt(np.maximum(np.arange(len(spectrum)), 1.0))
    return _unit(np.fft.irfft(spectrum, n))


def _unit(x: Values) -> Values:
    return x / max(float(x.std()), 1e-12)


def _slow(rng: Rng, n: int, seconds: float) -> Values:
    """Return slow noise: mean 0, standard deviation about 0.8, correlation time ``seconds``."""
    knots = max(2, math.ceil(n / FINGERTIP_RATE / seconds) + 2)
    at = np.linspace(0, knots - 1, n)
    out: Values = np.interp(at, np.arange(knots), rng.standard_normal(knots))
    return out


def _phase(rng: Rng, rate: Values | float, n: int, jitter: float) -> Values:
    """Return the angle of a shaft at each of ``n`` samples, in turns.

    ``rate`` is the speed in turns per second. It varies by the share ``jitter``.
    """
    speed = rate * (1.0 + jitter * _slow(rng, n, 0.05))
    return rng.random() + np.cumsum(np.broadcast_to(speed, n)) / FINGERTIP_RATE


def _pulses(turns: Values, heights: Values) -> Values:
    """Return a signal with a pulse at each sample where ``turns`` passes a whole number."""
    out = np.zeros(len(turns))
    hits = np.flatnonzero(np.diff(np.floor(turns)) > 0) + 1
    out[hits] = np.resize(heights, len(hits))
    return out


def _ring(x: Values, frequency: float, damping: float) -> Values:
    from scipy.signal import lfilter

    turn = 2 * math.pi * frequency / FINGERTIP_RATE
    radius = math.exp(-damping * turn)
    out: Values = lfilter([1.0], [1.0, -2 * radius * math.cos(turn), radius * radius], x)
    return out


def _brushes(rng: Rng, n: int, pace: Values, size: Mapping[str, float]) -> Values:
    """Return the noise of a brushed motor's commutator: pulses of uneven height.

    ``n`` is the number of samples, and ``pace`` the speed relative to the usual speed. ``size``
    holds the rig's random parameters by name.
    """
    turns = _phase(rng, 3 * size["rate"] * pace, n, 0.01)
    heights = np.exp(0.5 * rng.standard_normal(997)) * rng.choice((-1.0, 1.0), 997)
    return _unit(_ring(_pulses(turns, heights), size["ring"], 0.08) + 0.02 * _white(rng, n))


def _gearbox(rng: Rng, n: int, pace: Values, size: Mapping[str, float]) -> Values:
    """Return gear noise: a modulated tone, and a bad tooth that knocks once per turn."""
    shaft = _phase(rng, size["rate"] / 9.0 * pace, n, 0.01)
    mesh = (1.0 + 0.5 * np.sin(2 * np.pi * shaft)) * np.sin(2 * np.pi * 17 * shaft)
    mesh += 0.5 * np.sin(2 * np.pi * 34 * shaft + 1.0)
    knocks = _pulses(shaft, size["knock"] * np.exp(0.2 * rng.standard_normal(97)))
    rung = _ring(knocks, size["ring"], 0.12)
    rung *= size["knock"] / max(float(np.abs(rung).max()), 1e-9)
    return _unit(mesh + 0.4 * _pink(rng, n)) + rung


def _stick_slip(rng: Rng, n: int, pace: Values, size: Mapping[str, float]) -> Values:
    """Return the noise of a dry sliding guide: bursts of pink noise."""
    return _unit(_pink(rng, n) * np.exp(0.5 * _slow(rng, n, 0.02)))


def _stepper(rng: Rng, n: int, pace: Values, size: Mapping[str, float]) -> Values:
    """Return stepper-motor noise: clicks of its steps, whose height beats with another tone."""
    turns = _phase(rng, 2.5 * size["rate"] * pace, n, 0.002)
    beat = 1.0 + 0.4 * np.sin(2 * np.pi * _phase(rng, 0.13 * size["rate"], n, 0.02))
    square = np.sign(np.sin(2 * np.pi * turns)) * beat
    return _unit(_ring(np.diff(square, prepend=0.0), size["ring"], 0.1) + 0.05 * _white(rng, n))


def _servo(rng: Rng, n: int, pace: Values, size: Mapping[str, float]) -> Values:
    """Return servo noise: a whine whose loudness and pitch swing several times a second."""
    hunt = np.sin(2 * np.pi * _phase(rng, size["hunt"], n, 0.1))
    turns = _phase(rng, 4 * size["rate"] * pace * (1.0 + 0.1 * hunt), n, 0.01)
    whine = (1.0 + 0.6 * hunt) * (np.sin(2 * np.pi * turns) + 0.4 * np.sin(6 * np.pi * turns))
    return _unit(whine + 0.3 * _white(rng, n))


def _belt(rng: Rng, n: int, pace: Values, size: Mapping[str, float]) -> Values:
    """Return belt-drive noise: noise in a narrow band, and a slow rumble."""
    band = _unit(_ring(_white(rng, n), 0.4 * size["ring"], 0.06))
    return _unit(band * np.exp(0.3 * _slow(rng, n, 0.03)) + _slow(rng, n, 0.02))


Motor = Callable[[Rng, int, Values, Mapping[str, float]], Values]
MOTORS: Mapping[str, Motor] = {
    "brushes": _brushes,
    "gearbox": _gearbox,
    "stick_slip": _stick_slip,
    "stepper": _stepper,
    "servo": _servo,
    "belt": _belt,
}


def _disturbances(rng: Rng, n: int, size: Mapping[str, float]) -> tuple[Values, Values]:
    """Return (clicks of the gears, loudness of the motor), with ``n`` samples each.

    The clicks are multiples of the motor's RMS. ``size`` holds the rig's random parameters by name.
    """
    clicks, swells = np.zeros(n), np.ones(n)
    for start in rng.integers(0, n, rng.poisson(size["clicks"] * n / FINGERTIP_RATE)):
        length = int(rng.integers(1, 16))
        peak = CLICK * math.exp(0.5 * rng.standard_normal())
        rung = _ring(np.r_[rng.standard_normal(length), np.zeros(200)], size["ring"], 0.1)
        rung = peak * rung / np.abs(rung).max()
        clicks[start : start + len(rung)] += rung[: n - start]
    for start in rng.integers(0, n, rng.poisson(size["swells"] * n / FINGERTIP_RATE)):
        length = int(rng.uniform(0.02, 0.15) * FINGERTIP_RATE)
        shape = rng.uniform(0.5, SWELL) * np.hanning(length)
        swells[start : start + length] += shape[: n - start]
    return clicks, swells


def _hum(rng: Rng, n: int) -> Values:
    turns = 2 * np.pi * (rng.choice([50.0, 60.0]) * np.arange(n) / FINGERTIP_RATE + rng.random())
    out: Values = np.sin(turns) + 0.5 * np.sin(3 * turns) + 0.3 * np.sin(5 * turns)
    return out + _white(rng, n) / 3


def _bursts(rng: Rng, n: int) -> Values:
    """Return white noise with bursts of 0.2 to 3 ms. On average, two seconds have one burst."""
    out = _white(rng, n)
    for start in rng.integers(0, n, rng.poisson(0.5 * n / FINGERTIP_RATE)):
        length = int(rng.integers(1, 16))
        out[start : start + length] += 10.0 * _white(rng, len(out[start : start + length]))
    return out


def _popcorn(rng: Rng, n: int) -> Values:
    """Return popcorn noise: pink noise with a mean that jumps."""
    jumps = np.cumsum(rng.random(n) < 8.0 / FINGERTIP_RATE) % 2
    return _pink(rng, n) + 1.5 * jumps


FLOORS: Mapping[str, Callable[[Rng, int], Values]] = {
    "pink": _pink,
    "hum": _hum,
    "bursts": _bursts,
    "popcorn": _popcorn,
}


@dataclass(frozen=True, slots=True, eq=False)
class StructuredRig:
    """Simulated hand whose motor, noise and contact differ from the twin's."""

    seed: int
    motor: str
    floor: str
    rig: RandomRig
    size: Mapping[str, float]
    loud: float
    quiet: float
    thump: float
    overshoot: float
    settle: float
    coarse: int
    holder: tuple[float, float]

    def closing(self, key: str, target: RandomObject | None, label: Label, free: float) -> Pinch:
        """Simulate a closing from rest on the object ``target``, or on nothing if it is None.

        ``free`` is the time from the start of the motor to the contact, s.
        """
        rng = generator(self.seed, "closing", key)
        begin = round(REST * FINGERTIP_RATE)
        first = begin + round(free * FINGERTIP_RATE)
        n = first + round(AFTER * FINGERTIP_RATE)
        speed = math.exp(0.15 * rng.standard_normal())
        loud = self.loud * speed * math.exp(0.2 * rng.standard_normal())
        since = np.maximum(np.arange(n) - begin, 0) / FINGERTIP_RATE
        runs = np.arange(n) >= begin
        fade = np.exp(-since / self.settle)
        envelope = runs * (1.0 - np.exp(-since / 0.01)) * (1.0 + self.overshoot * fade)
        pace = speed * np.maximum(1.0 - fade, 0.05)
        contacts, touch = self._contact(rng, key, target, speed, first)
        volts = np.empty((n, 2))
        for finger in range(2):
            clicks, swells = _disturbances(rng, n, self.size)
            sound = MOTORS[self.motor](rng, n, pace, self.size) * swells + clicks
            sound *= envelope
            jolt = np.sin(2 * np.pi * self.size["jolt"] * since) * fade**2 * runs
            sound += self.thump * math.exp(0.3 * rng.standard_normal()) * jolt
            # A blocked drive slows down and becomes quieter.
            slowing = np.exp(-np.maximum(np.arange(n) - first, 0) / FINGERTIP_RATE / 0.1)
            sound *= slowing if contacts else 1.0
            volts[:, finger] = loud * sound + self.quiet * _unit(FLOORS[self.floor](rng, n))
        stop = min(n, first - round(LEAD * FINGERTIP_RATE) + len(touch))
        place = first - round(LEAD * FINGERTIP_RATE)
        volts[place:stop] += touch[: stop - place]
        data = self._sampled(volts)
        idle = data[: begin - 20, :2] * fingertip_layout().channels[0].scale
        floors = tuple(
            VibrationCalibration(f, float(max(idle[:, i].std(), 1e-5)))
            for i, f in enumerate(Finger)
        )
        return Pinch(data, fingertip_layout(), label, 0, contacts, calibration=Calibration(floors))

    def _contact(
        self, rng: Rng, key: str, target: RandomObject | None, speed: float, first: int
    ) -> tuple[tuple[Contact, ...], Values]:
        """Return (contacts of both fingers, voltages in V that they cause in both piezo discs)."""
        if target is None:
            return (), np.zeros((0, 2))
        draw = draw_pinch(self.seed, CONDITIONS["everyday"], "any", BLOCKS[0], key)
        place = np.exp(0.15 * rng.standard_normal(2))
        finger = self.rig.finger._replace(speed=self.rig.finger.speed * speed)
        fingers = [finger._replace(tip_radius=finger.tip_radius * p) for p in place]
        silent = replace(
            draw.noise[0], rotor=0.0, mesh=0.0, friction=0.0, click_rate=0.0, mains=0.0
        )
        draw = replace(
            draw,
            fingers=(fingers[0], fingers[1]),
            object=target.parameters,
            noise=(silent, silent),
            jitter=0.0,
        )
        draw = excerpt(draw, LEAD + rng.random() / FINGERTIP_RATE)
        _, out = integrate_pinch(draw, duration=LEAD + AFTER)
        touch = out[:, :, BUFFER] - out[:20, :, BUFFER].mean(axis=0)
        frequency, damping = self.holder
        touch += 0.3 * np.stack([_ring(np.gradient(x), frequency, damping) for x in touch.T], 1)
        fingers_in_order = [Finger.INDEX, Finger.THUMB]
        if not draw.timing.first_is_index:
            fingers_in_order.reverse()
        offset = round((draw.timing.second - draw.timing.first) * FINGERTIP_RATE)
        samples = (first, first + offset)
        return tuple(
            Contact(f, s, s) for f, s in zip(fingers_in_order, samples, strict=True)
        ), touch

    def _sampled(self, volts: Values) -> NDArray[np.int16]:
        """Return the samples that a device would send for these voltages (V)."""
        layout = fingertip_layout()
        step = 32 * layout.channels[0].scale
        counts = np.floor((volts + PIEZO_OFFSET_VOLTS) / (step * self.coarse)) * self.coarse
        counts = np.clip(counts, 0, 1023) * 32.0
        data = np.zeros((len(volts), layout.width), np.int16)
        state = counts[0]
        for i, row in enumerate(counts):
            state = np.floor((state + row) / 2)
            data[i, :2] = state
        return data


def draw_structured(seed: int, motor: str) -> StructuredRig:
    """Return a random rig with the motor ``motor``, one of :data:`MOTORS`."""
    rng = generator(seed, "structured", motor)
    rig = draw_rig(rng)
    finger = rig.finger._replace(
        pad_stiffening=0.0 if rng.random() < 0.5 else 3 * rig.finger.pad_stiffening,
        pad_arm_stiffness=rig.finger.pad_arm_stiffness * float(rng.uniform(0.0, 2.0)),
        buffer_cutoff=float(rng.uniform(500, 900)),
    )
    peak = _hard_peak(seed, replace(rig, finger=finger))
    coarse = int(rng.choice([1, 1, 2]))
    # If the motor were below the steps of the converter, no gate would detect a closing.
    step = 32 * fingertip_layout().channels[0].scale
    loud = max(peak / math.exp(rng.uniform(*np.log(CLEAR))), 1.2 * coarse * step)
    return StructuredRig(
        seed=seed,
        motor=motor,
        floor=str(rng.choice(list(FLOORS))),
        rig=replace(rig, finger=finger),
        size={
            "rate": float(rng.uniform(60, 300)),
            "ring": float(rng.uniform(250, 1800)),
            "knock": float(rng.uniform(3, 7)),
            "hunt": float(rng.uniform(4, 15)),
            "jolt": float(rng.uniform(15, 60)),
            "clicks": float(rng.uniform(0, CLICKS)),
            "swells": float(rng.uniform(0, SWELLS)),
        },
        loud=loud,
        quiet=loud / float(rng.uniform(2.5, 6.0)),
        thump=float(rng.uniform(0, 8)),
        overshoot=float(rng.uniform(0, 1.5)),
        settle=float(rng.uniform(0.02, 0.12)),
        coarse=coarse,
        holder=(float(rng.uniform(300, 2000)), float(rng.uniform(0.03, 0.2))),
    )


def _hard_peak(seed: int, rig: RandomRig) -> float:
    """Return the largest voltage when the rig touches a hard flat block, V."""
    size = {"ring": 400.0, "jolt": 20.0, "clicks": 0.0, "swells": 0.0}
    plain = StructuredRig(
        seed, "belt", "pink", rig, size, 0.0, 0.0, 0.0, 0.0, 0.1, 1, (500.0, 0.2)
    )  # fmt: skip
    rng = generator(seed, "hard")
    _, touch = plain._contact(rng, "hard", draw_block(rng, 60.0, 0.0), 1.0, 0)
    return float(np.abs(touch).max())


def draw_blocks(rig: StructuredRig, levels: tuple[float, ...], each: int, sessions: int) -> Dataset:
    """Simulate closings on blocks: ``each`` closings per Shore A in ``levels``.

    They are divided among ``sessions`` sessions.
    """
    pinches = []
    for level in levels:
        for number in range(each):
            session = f"blocks-{number % sessions + 1}"
            key = f"block {level:g} {number}"
            rng = generator(rig.seed, "block", key)
            target = draw_block(rng, level, rig.rig.block_scatter)
            label = Label(f"{level:g}", level, None, f"{level:g}", session, Role.TRAIN)
            pinches.append(rig.closing(key, target, label, float(rng.uniform(*FREE))))
    return Dataset(tuple(pinches), "synthetic")


def draw_objects(rig: StructuredRig, count: int) -> Dataset:
    """Simulate closings on random objects, which lose more energy than objects in training."""
    pinches = []
    for number in range(count):
        rng = generator(rig.seed, "object", number)
        target = draw_object(rng)
        more = float(rng.uniform(1.0, 2.0))
        parameters = target.parameters._replace(arm_share=target.parameters.arm_share * more)
        target = replace(target, parameters=parameters)
        shore_a = float(np.clip(target.shore_a + LABEL * rng.standard_normal(), 0.0, 100.0))
        label = Label(f"object {number}", shore_a, None, f"object {number}", "objects", Role.TEST)
        pinches.append(rig.closing(f"object {number}", target, label, float(rng.uniform(*FREE))))
    return Dataset(tuple(pinches), "synthetic")


def draw_empty(rig: StructuredRig, count: int, free: float) -> Dataset:
    pinches = [rig.closing(f"empty {i}", None, Label(), free) for i in range(count)]
    return Dataset(tuple(pinches), "synthetic")
