"""Simulated pinches of random rigs, from families of rigs that no network was trained on.

A family changes the structure of a rig, for example its motor.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Record
from firstcontact.core.layout import ADC_COUNTS, ADC_VOLTS, FINGERTIP_RATE, SUBCOUNTS
from firstcontact.models import Touches
from firstcontact.models.scores import Ends, bootstrap_interval, resampled_sums
from firstcontact.signal import samples_in
from firstcontact.twin import BLOCKS, CONDITIONS
from firstcontact.twin.draw import draw_offset, draw_specimen
from firstcontact.twin.noise import MotorNoise
from firstcontact.twin.objects import EVERYDAY_OBJECTS
from firstcontact_lab.report.tables import Bounded, Cell, format_cell
from firstcontact_lab.rigs import (
    FAMILIES,
    Day,
    Family,
    RandomObject,
    RandomRig,
    Rng,
    draw_block,
    draw_day,
    draw_object,
    draw_rig,
    touch,
)

Values = NDArray[np.float64]
#: Delay of placed contacts in samples, mean and standard deviation: twice as variable as in the
#: training of the network. No delay is longer than ``MARGIN``.
DELAY, MARGIN = (3.0, 2.5), 12
#: The same for contacts that are all placed alike, and for those that copper strips find.
ALIKE, STRIPS = (3.0, 0.0), (0.0, 0.5)
LABEL = 2.0
#: Number of pinches of each block, and number of sessions. Rigs use the pairs in turn.
CONTEXTS = (6, 3), (12, 4), (20, 6)
#: Numbers of pinches and sessions of each predicted block, of random objects, and of pinches of
#: each object.
HELD_OUT, OBJECTS, AGAIN = (4, 2), 24, 3
#: Uses of a pinch: block pinches of the rig itself to learn from, and blocks, everyday objects and
#: random objects to predict.
OWN, BLOCK, EVERYDAY, RANDOM = "own", "blocks", "everyday", "random"
#: Factors between which the closing speed of a rig with free speed is drawn for each pinch,
#: log-uniform.
FREE_SPEED = (0.5, 2.0)
#: Largest radius of a round object, m. Larger ones are flat.
_FLAT = 1.0
_RATE = FINGERTIP_RATE

Change = Callable[[Values, Rng], Values]


def _lossy(target: RandomObject, rng: Rng) -> RandomObject:
    p = target.parameters
    share = 0.3 + p.arm_share * float(rng.uniform(1.8, 3.0))
    return replace(target, parameters=p._replace(arm_share=share))


def _several_rig(rig: RandomRig, rng: Rng) -> RandomRig:
    for name in ("linear_pad", "duller_sensor", "silent_motor"):
        rig = FAMILIES[name].rig(rig, rng)
    return rig


def _several_object(target: RandomObject, rng: Rng) -> RandomObject:
    return FAMILIES["slow_material"].change_object(_lossy(target, rng), rng)


def _gearbox(rng: Rng) -> Change:
    """Return a function that adds a gearbox's noise to a signal: tones, pink noise and a jolt."""
    line, swell = float(rng.uniform(250, 900)), float(rng.uniform(15, 60))
    loud, decay = float(rng.uniform(0.005, 0.03)), float(rng.uniform(0.005, 0.02))

    def change(signal: Values, rng: Rng) -> Values:
        t = np.arange(len(signal)) / _RATE
        lines = np.zeros(len(signal))
        for order in (1, 2, 3):
            pitch = order * line * (1 + 0.05 * rng.standard_normal())
            lines += np.sin(2 * math.pi * pitch * t + rng.uniform(0, 6)) / order
        spectrum = np.fft.rfft(rng.standard_normal(len(signal)))
        pitches = np.maximum(np.fft.rfftfreq(len(signal), 1 / _RATE), 40.0)
        pink = np.fft.irfft(spectrum / np.sqrt(pitches), len(signal))
        swelling = 1 + 0.8 * np.sin(2 * math.pi * swell * t + rng.uniform(0, 6))
        start = 3 * np.exp(-t / decay) * np.sin(2 * math.pi * 180 * t)
        noise: Values = loud * (swelling * lines + 0.5 * pink / pink.std() + start)
        return signal + noise

    return change


def _compressive(rng: Rng) -> Change:
    """Return a function that compresses a signal: it shrinks large values more than small ones."""
    power, unit = float(rng.uniform(0.65, 0.85)), float(rng.uniform(0.1, 0.5))

    def change(signal: Values, rng: Rng) -> Values:
        baseline = np.median(signal[: len(signal) // 4])
        moved = signal - baseline
        out: Values = baseline + np.sign(moved) * unit * np.abs(moved / unit) ** power
        return out

    return change


STRUCTURES: Mapping[str, Family] = {
    **FAMILIES,
    "lossy": Family("loss outside the training range", change_object=_lossy),
    "gearbox": Family("a gearbox, pink noise and a start-up transient"),
    "compressive": Family("a compressive sensor"),
    "several": Family("several of these", rig=_several_rig, change_object=_several_object),
}
_SIGNALS: Mapping[str, Callable[[Rng], Change]] = {
    "gearbox": _gearbox, "several": _gearbox, "compressive": _compressive,
}  # fmt: skip
#: Families whose objects are materials, so that everyday objects can be made of them.
_MATERIALS = ("lossy", "slow_material", "several")


class RigScores(Record, frozen=True, kw_only=True):
    """Mean scores of one method over random rigs, with intervals.

    The keys name the scores: RMSE in Shore A, coverage of intervals, or width of intervals.
    ``gains`` are intervals of the difference from a reference method.
    """

    scores: dict[str, float]
    intervals: dict[str, Ends]
    gains: dict[str, Ends]

    def cell(self, key: str, unit: str) -> Cell:
        """Return the score ``key`` as a table cell with its interval.

        For scores in Shore A, the cell also has the gain over the reference method.
        """
        if key not in self.scores:  # results of an older version
            return format_cell(None, unit)
        cell = format_cell(Bounded(self.scores[key], self.intervals[key]), unit)
        low, high = self.gains[key]
        if unit != "shore" or low == high == 0.0:
            return cell
        return Cell(cell.text, f"{cell.small} [{low:+.2f} to {high:+.2f}]")


def rig_scores(rows: Values, keys: Sequence[str], seed: int) -> list[list[RigScores]]:
    """Return mean scores over rigs, as a list of methods for each group.

    ``rows`` has the shape (rigs, groups, methods, keys). For an RMSE it holds squared errors. The
    gains are differences from the first method of a group.
    """
    is_error = np.array([key.split()[-1] not in ("bias", "coverage", "width") for key in keys])

    def rooted(means: Values) -> Values:
        return np.where(is_error, np.sqrt(np.abs(means)), means)

    means = rooted(rows.mean(axis=0))
    resampled = rooted(resampled_sums(rows, seed) / len(rows))

    def ends(values: Values) -> dict[str, Ends]:
        columns = bootstrap_interval(values, len(rows)).T.tolist()
        return dict(zip(keys, map(tuple, columns), strict=True))

    return [
        [
            RigScores(
                scores=dict(zip(keys, means[group, place].tolist(), strict=True)),
                intervals=ends(resampled[:, group, place]),
                gains=ends(resampled[:, group, place] - resampled[:, group, 0]),
            )
            for place in range(rows.shape[2])
        ]
        for group in range(rows.shape[1])
    ]


def plan_rig_jobs(brief: bool, rigs: int) -> tuple[list[str], int, list[tuple[str, int]]]:
    """Return (names of families, number of rigs per family, jobs).

    There is one job (family, number) per rig. ``brief`` selects few rigs for a quick trial.
    """
    names, count = (["linear_pad", "several"], 1) if brief else (list(STRUCTURES), rigs)
    return names, count, [(name, number) for number in range(count) for name in names]


@dataclass(frozen=True, slots=True, eq=False)
class LabelledRig:
    touches: Touches
    shore_a: Values
    uses: NDArray[np.str_]
    sessions: NDArray[np.str_]
    objects: NDArray[np.str_]
    radii: Values
    speeds: Values


def simulate_labelled_rig(
    name: str,
    number: int,
    seed: int,
    *,
    free_speed: bool = False,
    delay: tuple[float, float] = DELAY,
    is_quiet: bool = False,
) -> LabelledRig:
    """Simulate rig ``number`` of the family ``name``, and return its contacts with their labels.

    With ``free_speed``, the closing speed is random. ``delay`` is (mean, standard deviation) of the
    time from a contact to where a detector places it, in samples. With ``is_quiet``, the rig has a
    tenth of its noise and no clicks. These options change nothing else of the rig.
    """
    rng = np.random.default_rng([seed, number, list(STRUCTURES).index(name)])
    family = STRUCTURES[name]
    rig = family.rig(draw_rig(rng), rng)
    change = _SIGNALS[name](rng) if name in _SIGNALS else None
    pinches = []

    def add(use: str, label: float, session: int, name: str, day: Day, o: RandomObject) -> None:
        hand = _at_free_speed(rig, rng) if free_speed else rig
        signal, valid, speed = _pinch(hand, day, o, change, delay, is_quiet, rng)
        radius = o.parameters.radius
        pinches.append((use, label, f"{use} {session}", name, signal, valid, radius, speed))

    levels = [kind.shore_a for kind in BLOCKS]
    labels = {level: _label(level, rng) for level in levels}
    blocks = {
        level: [draw_block(rng, level, rig.block_scatter) for _ in range(2)] for level in levels
    }
    for use, (each, sessions) in ((OWN, CONTEXTS[number % len(CONTEXTS)]), (BLOCK, HELD_OUT)):
        days = [draw_day(rng) for _ in range(sessions)]
        for level in levels:
            for k in range(each):
                specimen = blocks[level][rng.integers(2)]
                day = k % sessions
                add(use, labels[level], day, f"block {level:g}", days[day], specimen)
    days = [draw_day(rng) for _ in range(2)]
    for k in range(OBJECTS):
        target = family.change_object(draw_object(rng), rng)
        label = _label(target.shore_a, rng)
        for _ in range(AGAIN):
            add(RANDOM, label, k % 2, f"object {k}", days[k % 2], target)
    for kind in EVERYDAY_OBJECTS:
        drawn = draw_specimen(int(rng.integers(1 << 30)), CONDITIONS["paper-rig"], kind, 0)
        target = RandomObject(kind.shore_a, drawn.nominal)
        if name in _MATERIALS:
            target = family.change_object(target, rng)
        label = _label(kind.shore_a, rng)
        for _ in range(AGAIN):
            add(EVERYDAY, label, 0, kind.name, days[0], target)
    uses, shore_a, session_names, objects, signals, valid, radii, speeds = map(
        np.array, zip(*pinches, strict=True)
    )
    touches = Touches.from_signals(
        signals, np.minimum(valid, Touches.lengths(_RATE)[1]), np.full(len(valid), -1), _RATE
    )
    touches = replace(touches, radii=np.where(np.isin(uses, (OWN, BLOCK)), np.inf, np.nan))
    lasting = touches.answerable
    return LabelledRig(
        touches.take(lasting),
        shore_a[lasting],
        uses[lasting],
        session_names[lasting],
        objects[lasting],
        np.where(radii > _FLAT, np.inf, radii)[lasting],
        speeds[lasting],
    )


def _quiet(noise: MotorNoise) -> MotorNoise:
    return replace(
        noise.scaled(1.0, 0.1),
        click_rate=0.0,
        mains=0.1 * noise.mains,
        hum=0.1 * noise.hum,
        electronics=0.1 * noise.electronics,
    )


def _at_free_speed(rig: RandomRig, rng: Rng) -> RandomRig:
    """Return the rig with a random closing speed. The speed of its motor changes in proportion."""
    factor = math.exp(rng.uniform(*np.log(FREE_SPEED)))
    finger = rig.finger._replace(speed=rig.finger.speed * factor)
    return replace(rig, finger=finger, noise=rig.noise.scaled(factor, 1.0))


def draw_delay(rng: Rng, delay: tuple[float, float]) -> int:
    """Return a random delay in samples, from a contact to where a detector places it.

    ``delay`` is (mean, standard deviation).
    """
    return int(np.clip(round(rng.normal(*delay)), -MARGIN, MARGIN))


def _label(shore_a: float, rng: Rng) -> float:
    return shore_a + LABEL * float(np.clip(rng.standard_normal(), -2.5, 2.5))


def _pinch(
    rig: RandomRig,
    day: Day,
    target: RandomObject,
    change: Change | None,
    delay: tuple[float, float],
    is_quiet: bool,
    rng: Rng,
) -> tuple[NDArray[np.float32], int, float]:
    """Simulate the first contact of a pinch.

    Return (signal in V, number of valid samples, closing speed in m/s).

    Samples from the second contact on are not valid.
    """
    more = MARGIN / _RATE
    lengths = Touches.BEFORE + more, Touches.LONGEST + more
    unheard = replace(rig, noise=_quiet(rig.noise))
    quiet = touch(unheard, day, target, deepcopy(rng), *lengths) if is_quiet else None
    # The loud contact is simulated in any case, so that all later draws are the same.
    loud = touch(rig, day, target, rng, *lengths)
    counts, speed = quiet or loud
    signal = counts.astype(np.float64) * (ADC_VOLTS / (ADC_COUNTS * SUBCOUNTS))
    if change is not None:
        signal = change(signal, rng)
    late = draw_delay(rng, delay)
    start = samples_in(Touches.BEFORE, _RATE)
    touched = Touches.cut_signal(signal, start + MARGIN + late, _RATE)
    if touched is None:
        touched = np.zeros(start + samples_in(Touches.LONGEST, _RATE), np.float32)
    return touched, max(round(draw_offset(rng) * _RATE) - late, 0), speed
