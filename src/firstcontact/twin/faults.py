"""Electronics and link of simulated fingertips for the self-test, healthy or with one fault.

The sizes of faults follow from the circuit, not from the limits of the self-test. A step of the
converter is 3.2 mV.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import ArgumentError
from firstcontact.core.layout import TAXELS
from firstcontact.twin.disc import VOLTS_PER_NEWTON
from firstcontact.twin.draw import PinchDraw
from firstcontact.twin.mechanics import FingerParameters
from firstcontact.twin.noise import MotorNoise

#: Time over which a drift is stated, s.
DRIFT_TIME = 300.0


@dataclass(frozen=True, slots=True, eq=False)
class Bench:
    """Electronics and link of both fingertips. Arrays have the index finger first."""

    fingers: tuple[FingerParameters, FingerParameters]
    noise: tuple[MotorNoise, MotorNoise]
    offset: NDArray[np.float64]
    """Offset of each piezo, V."""
    drift: NDArray[np.float64]
    """Change of the offset in the first five minutes, V."""
    warming: float
    """Time constant of that change, s."""
    signal: NDArray[np.float64]
    """Factor on each piezo's signal: 1 in a healthy fingertip, negative if the disc is reversed."""
    corners: NDArray[np.float64]
    """Factor on each piezo's signal for a tap on a corner of the pad, relative to the middle."""
    array: NDArray[np.float64]
    """Weight of each taxel (last axis) in the reading of each taxel, shape (2, 6, 6)."""
    swapped: bool = False
    lost: float = 0.0
    """Share of the frames that the link loses."""
    stall: float = 0.0
    """Time for which the link holds frames back, s."""
    stall_period: float = math.inf
    """Mean time between two such stalls, s."""


def healthy(draw: PinchDraw, rng: np.random.Generator) -> Bench:
    """Draw the electronics of two healthy fingertips, within the tolerances of their parts.

    The divider of 1.65 V has 1 % resistors: +-16.5 mV. The amplifier adds up to 1.2 steps
    (``docs/results/circuit.json``), and the converter up to 2 (assumption).
    """
    spread = np.exp(rng.normal(0, [[0.3], [0.5]], (2, 2)))  # of noise and hum: assumption
    noise = [
        replace(n, electronics=n.electronics * spread[0, f], hum=n.hum * spread[1, f])
        for f, n in enumerate(draw.noise)
    ]
    divider = 1.65 * (rng.uniform(-0.01, 0.01) - rng.uniform(-0.01, 0.01)) / 2
    return Bench(
        draw.fingers,
        (noise[0], noise[1]),
        divider + rng.uniform(-3.9e-3, 3.9e-3, 2) + rng.uniform(-6.4e-3, 6.4e-3, 2),
        rng.uniform(-5e-3, 5e-3, 2),
        rng.uniform(60, 300),
        np.ones(2),
        np.full(2, VOLTS_PER_NEWTON[0] / VOLTS_PER_NEWTON[2]),
        np.stack([np.eye(TAXELS)] * 2),
    )


Change = Callable[[Bench, int, np.random.Generator], Bench]


def _with(values: NDArray[np.float64], finger: int, value: float) -> NDArray[np.float64]:
    changed = values.copy()
    changed[finger] = value
    return changed


def _signal(bench: Bench, finger: int, factor: float) -> Bench:
    return replace(bench, signal=_with(bench.signal, finger, factor))


def _noise(bench: Bench, finger: int, **changes: float) -> Bench:
    noise = list(bench.noise)
    noise[finger] = replace(noise[finger], **changes)
    return replace(bench, noise=(noise[0], noise[1]))


def _rattle(bench: Bench, finger: int, rng: np.random.Generator) -> Bench:
    fingers = list(bench.fingers)
    p = fingers[finger]
    stiffness = p.mount_stiffness * rng.uniform(0.02, 0.1)
    critical = 2 * math.sqrt(stiffness * p.board_mass)
    fingers[finger] = p._replace(
        mount_stiffness=stiffness, mount_damping=critical * rng.uniform(0.01, 0.02)
    )
    return replace(bench, fingers=(fingers[0], fingers[1]))


def _with_faulty_line(
    bench: Bench, finger: int, rng: np.random.Generator, axis: int, *, short: bool
) -> Bench:
    """Return the fingertips with one broken line in the force array of ``finger``.

    A line is a row (``axis`` 0) or a column (``axis`` 1). A random line is cut or, with ``short``,
    connected with another one. Undriven rows are at ground. So a driven row that is connected with
    another gets half of the supply, and two connected columns have their dividers in parallel: both
    read the mean.
    """
    lines = np.moveaxis(np.arange(TAXELS).reshape(3, 2), axis, 0)
    first, second = lines[rng.permutation(len(lines))[:2]]
    array = bench.array.copy()
    if short:
        for pair in zip(first, second, strict=True):
            array[finger][np.ix_(pair, pair)] = 0.5
    else:
        array[finger][first] = 0.0
    return replace(bench, array=array)


def _sign(rng: np.random.Generator) -> float:
    return float(rng.choice((-1.0, 1.0)))


#: What each fault does to the fingertips. It gets a random finger and a random generator.
FAULTS: dict[str, Change] = {
    # Leakage of a BAT54S at 27 to 50 C: 44 to 312 steps. A wrong resistor at the reference.
    "offset": lambda b, f, rng: replace(
        b, offset=_with(b.offset, f, _sign(rng) * rng.uniform(0.06, 0.5))
    ),
    # A ground that carries the motor's current, or no capacitor at the supply.
    "noise": lambda b, f, rng: _noise(b, f, electronics=rng.uniform(0.015, 0.06)),
    # 0.15 to 1 pF from 230 V to the disc's wire, into 470 kOhm beside 5.9 nF, times 7.5.
    "hum": lambda b, f, rng: _noise(b, f, hum=rng.uniform(0.03, 0.2)),
    # The two cables are exchanged.
    "swapped": lambda b, f, rng: replace(b, swapped=True),
    "polarity": lambda b, f, rng: _signal(b, f, -1.0),
    # A wire of the disc is broken.
    "open-disc": lambda b, f, rng: _signal(b, f, 0.0),
    # The board touches the walls, which then carry the force past the disc; or the glue has a gap.
    "glue": lambda b, f, rng: _signal(b, f, rng.uniform(0.03, 0.15)),
    # Epoxy on both faces: 1.3 times the signal at the middle dimples. The corners have -5.1 times
    # that, with a disc of 0.1 mm -6.3 times.
    "epoxy": lambda b, f, rng: replace(
        _signal(b, f, rng.uniform(1.0, 1.5)), corners=_with(b.corners, f, rng.uniform(-8.0, -3.0))
    ),
    # Nine times the gain: 510 Ohm in place of 5.1 kOhm, or 330 kOhm in place of 33 kOhm.
    "clipping": lambda b, f, rng: _signal(b, f, rng.uniform(8.0, 10.0)),
    # Loose screws: a tenth of the stiffness or less, and hardly any damping.
    "rattle": _rattle,
    "open-row": lambda b, f, rng: _with_faulty_line(b, f, rng, 0, short=False),
    "open-column": lambda b, f, rng: _with_faulty_line(b, f, rng, 1, short=False),
    "shorted-rows": lambda b, f, rng: _with_faulty_line(b, f, rng, 0, short=True),
    "shorted-columns": lambda b, f, rng: _with_faulty_line(b, f, rng, 1, short=True),
    "lost": lambda b, f, rng: replace(b, lost=rng.uniform(0.001, 0.02)),
    # A hub or a busy computer that holds the stream back.
    "jitter": lambda b, f, rng: replace(
        b, stall=rng.uniform(0.03, 0.08), stall_period=rng.uniform(0.2, 0.5)
    ),
    # A clamp diode that warms up.
    "drift": lambda b, f, rng: replace(
        b, drift=_with(b.drift, f, _sign(rng) * rng.uniform(0.04, 0.4))
    ),
}


def put_fault(bench: Bench, name: str, rng: np.random.Generator) -> Bench:
    """Return the fingertips with the fault ``name``, in a random finger and of random size."""
    if name and name not in FAULTS:
        raise ArgumentError(
            f"the fault {name!r} is not known: use one of {', '.join(FAULTS)}", parameter="fault"
        )
    return FAULTS[name](bench, int(rng.integers(2)), rng) if name else bench


class Link:
    """Simulated link to the computer, which loses some frames and delays others."""

    def __init__(self, bench: Bench, rng: np.random.Generator) -> None:
        self._bench, self._rng = bench, rng
        self._begin = self._end = -math.inf

    def loses(self) -> bool:
        """Return True if the link loses the next frame."""
        return self._bench.lost > 0 and self._rng.random() < self._bench.lost

    def release(self, now: float) -> float:
        """Return the time at which a frame sent at ``now`` arrives, s."""
        if not self._bench.stall:
            return now
        while now >= self._end:
            start = now if math.isinf(self._end) else self._end
            self._begin = start + self._bench.stall_period * self._rng.uniform(0.5, 1.5)
            self._end = self._begin + self._bench.stall
        return self._end if now >= self._begin else now
