"""Simulated self-test: raw scans of two fingertips that a simulated person taps and presses.

A tap is a free mass that strikes the pad, simulated by the mechanics of a pinch.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import ArgumentError, Finger
from firstcontact.core.layout import FINGERTIP_RATE, TAXELS
from firstcontact.twin._run import SUBSTEPS
from firstcontact.twin.draw import condition, draw_pinch, generator
from firstcontact.twin.faults import DRIFT_TIME, Link, healthy, put_fault
from firstcontact.twin.mechanics import (
    BUFFER,
    CONTACT_FORCE,
    FINGER_STATES,
    INDENTATION,
    OUTPUTS,
    STATES,
    ObjectParameters,
    Piece,
    contact_stiffness,
    integrate_all,
)
from firstcontact.twin.objects import block
from firstcontact.twin.sensor import ScanStream, StreamFingertips

#: Largest number of samples computed at a time while nothing is touched, 50 ms.
PIECE = 250
#: Time for which a tap is computed, s.
TAP = 0.15
#: Time from the start of the computation of a tap to the contact, s.
LEAD = 2e-3
#: Share of the places that the person forgets to press.
MISSED = 0.03
#: Factor on the speed of taps after a request to tap more gently or harder.
REQUESTED = {"gentler": 0.8, "harder": 1.25}

Motion = NDArray[np.float64]


class Tester:
    """Simulated person who tests fingertips. Strength, tool and habits are assumptions."""

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng = rng
        self.speed = 0.2 * math.exp(0.4 * rng.standard_normal())
        self.doubles = float(rng.uniform(0.0, 0.15))
        self.press_force = float(rng.uniform(2.0, 6.0))
        self.aim = float(rng.uniform(0.45, 0.75))
        # The blunt end of a pencil or a pen.
        self.tool = ObjectParameters(
            modulus=math.exp(rng.uniform(math.log(5e6), math.log(1e9))),
            radius=float(rng.uniform(2e-3, 4e-3)),
            face_mass=float(rng.uniform(4e-3, 10e-3)),
            bulk_stiffness=0.0, bulk_damping=0.0, clamp_stiffness=0.0, clamp_damping=0.0,
        )  # fmt: skip

    def taps(self) -> Iterator[tuple[float, float]]:
        """Yield each tap as a pair: time before the tap, s, and speed of the tool, m/s."""
        yield float(self._rng.uniform(0.5, 1.5)), self._tap_speed()
        while True:
            if self._rng.random() < self.doubles:
                yield float(self._rng.uniform(0.02, 0.08)), self._tap_speed() / 2
            yield float(self._rng.uniform(0.4, 0.9)), self._tap_speed()

    def presses(self) -> Iterator[tuple[float, float, NDArray[np.float64]]]:
        """Yield (wait, force, shares) of presses on the six places of a pad.

        ``wait`` is the time before the press, s, and ``force`` is in N. ``shares`` holds the share
        of the force on each force cell, shape (6,).
        """
        for taxel in self._rng.permutation(TAXELS):
            if self._rng.random() < MISSED:
                continue
            shares = (1 - self.aim) * self._rng.dirichlet(np.full(TAXELS, 4.0))
            shares[taxel] += self.aim
            force = self.press_force * math.exp(0.2 * self._rng.standard_normal())
            yield float(self._rng.uniform(0.3, 0.7)), force, shares

    def _tap_speed(self) -> float:
        return max(self.speed * math.exp(0.25 * float(self._rng.standard_normal())), 0.02)


class BenchStream(ScanStream):
    """Endless raw scans of two fingertips. ``fault`` is a name in ``faults.FAULTS``, or ""."""

    def __init__(self, condition_name: str = "paper-rig", seed: int = 0, fault: str = "") -> None:
        super().__init__()
        key = (condition_name, "bench")
        draw = draw_pinch(seed, condition(condition_name), "bench", block(29), "bench")
        rng = generator(seed, *key)
        self.bench = put_fault(healthy(draw, rng), fault, generator(seed, *key, "fault"))
        self.link = Link(self.bench, generator(seed, *key, "link"))
        self._tips = StreamFingertips(
            replace(draw, fingers=self.bench.fingers, noise=self.bench.noise), rng
        )
        self._draw = self._tips._draw
        self._coupling = float(rng.uniform(0.02, 0.12))  # of a tap to the other finger: assumption
        self._tester = Tester(generator(seed, *key, "person"))
        self._rng = rng
        self._task: tuple[str, Finger] | None = None
        self._moves = self._move()
        self._readings = np.zeros((2, TAXELS))

    def obey(self, words: str) -> None:
        """Give the simulated person a task. Raise InputError for unknown words.

        The tasks are "rest", "tap index", "tap index corners", "press index", the same for the
        thumb, "gentler" and "harder".
        """
        match words.split():
            case ["rest"]:
                self._task = None
            case ["gentler" | "harder" as request]:
                self._tester.speed *= REQUESTED[request]
                return
            case ["tap" | "press" as task, "index" | "thumb" as name]:
                self._task = task, Finger[name.upper()]
            case ["tap", "index" | "thumb" as name, "corners"]:
                self._task = "corners", Finger[name.upper()]
            case _:
                raise ArgumentError(
                    f"the person's task {words!r} is not known: use rest, tap index or press index"
                )
        self._moves = self._move()

    def _next_scans(self) -> NDArray[np.uint16]:
        motion = next(self._moves)
        bench, first = self.bench, self._tips.sample
        times = (first + np.arange(len(motion))) / FINGERTIP_RATE
        warm = 1 - math.exp(-DRIFT_TIME / bench.warming)
        drift = (1 - np.exp(-times / bench.warming)) / warm
        motion[..., BUFFER] = (
            motion[..., BUFFER] * bench.signal + bench.offset + drift[:, None] * bench.drift
        )
        motion[..., INDENTATION] = -1.0  # there are no strips
        scans = self._tips.read(motion)
        for f in map(int, np.flatnonzero((bench.array != np.eye(TAXELS)).any(axis=(1, 2)))):
            scans[:, 2 + f] = self._faulty_readings(scans[:, 2 + f], first, f)
        return scans[:, [1, 0, 3, 2, 5, 4]] if bench.swapped else scans

    def _faulty_readings(
        self, counts: NDArray[np.uint16], first: int, finger: int
    ) -> NDArray[np.uint16]:
        """Return the readings of a force array whose rows or columns are cut or connected.

        ``counts`` are the readings of the same array without the fault. ``first`` is the number of
        their first sample.
        """
        taxel = (first + np.arange(len(counts))) % TAXELS
        # The newest reading of each taxel, up to each sample.
        place = np.where(taxel[:, None] == np.arange(TAXELS), np.arange(len(taxel))[:, None], -1)
        place = np.maximum.accumulate(place, axis=0)
        newest = np.where(place >= 0, counts[np.maximum(place, 0)], self._readings[finger])
        self._readings[finger] = newest[-1]
        mixed = (newest * self.bench.array[finger][taxel]).sum(axis=1)
        return np.asarray(np.rint(mixed), np.uint16)

    def _move(self) -> Iterator[Motion]:
        """Yield the motion of both fingertips without end, as the person's task requires."""
        if self._task is not None and self._task[0] in ("tap", "corners"):
            task, finger = self._task
            place = self.bench.corners[finger] if task == "corners" else 1.0
            for wait, speed in self._tester.taps():
                yield from self._rest(wait)
                motion = self._tap(finger, speed)
                motion[:, finger, BUFFER] *= place
                yield motion
        elif self._task is not None:
            finger = self._task[1]
            yield from self._rest(float(self._rng.uniform(0.5, 1.5)))
            for wait, force, shares in self._tester.presses():
                yield from self._rest(wait)
                yield self._press(finger, force, shares)
        while True:
            yield from self._rest(1.0)

    def _rest(self, duration: float) -> Iterator[Motion]:
        left = round(duration * FINGERTIP_RATE)
        while left > 0:
            yield np.zeros((min(left, PIECE), 2, OUTPUTS))
            left -= PIECE

    def _press(self, finger: Finger, force: float, shares: NDArray[np.float64]) -> Motion:
        times = self._rng.uniform((0.1, 0.4, 0.1), (0.3, 0.8, 0.3))  # rise, hold, fall, s
        n = round(float(times.sum()) * FINGERTIP_RATE)
        knots = np.concatenate([[0.0], np.cumsum(times)]) * FINGERTIP_RATE
        motion = np.zeros((n, 2, OUTPUTS))
        motion[:, finger, CONTACT_FORCE] = np.interp(np.arange(n), knots, [0, force, force, 0])
        on_finger = self._draw.shares.copy()
        on_finger[finger] = shares
        self._tips._draw = replace(self._draw, shares=on_finger)
        return motion

    def _tap(self, finger: Finger, speed: float) -> Motion:
        """Return the motion of both fingertips after a tool strikes one pad at ``speed`` m/s.

        The other fingertip shakes a little, too.
        """
        towards = -1.0 if finger is Finger.INDEX else 1.0
        state = np.zeros(STATES)
        face = 2 * FINGER_STATES + 2 * finger
        state[face : face + 2] = -towards * speed * LEAD, towards * speed
        gap = np.ones(2)
        gap[finger] = 0.0
        n = round(TAP * FINGERTIP_RATE)
        index, thumb = self.bench.fingers
        tool = self._tester.tool
        stiffness = np.array([contact_stiffness(p, tool) for p in (index, thumb)])
        motion = np.empty((n, 2, OUTPUTS))
        integrate_all([
            Piece(
                index, thumb, tool, stiffness, np.full(2, math.inf),
                np.arange(n) / FINGERTIP_RATE, np.zeros((2, 2)), 1.0, SUBSTEPS, np.zeros((1, 2)),
                index.drive_force, 0.0, 0.0, math.inf, math.inf, SUBSTEPS,
                state, gap, np.full(2, math.nan), motion,
            )
        ])  # fmt: skip
        motion[:, finger.other, BUFFER] = self._coupling * motion[:, finger, BUFFER]
        motion[..., CONTACT_FORCE] = 0.0  # too short for the force-sensitive sheet
        return motion
