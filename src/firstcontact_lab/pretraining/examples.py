"""Training examples from random simulated rigs: contacts, and the contexts of the rigs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from safetensors.numpy import load_file, save

from firstcontact.chain.touch import HINTS, touch_constants
from firstcontact.core.files import replacing
from firstcontact.core.layout import ADC_COUNTS, ADC_VOLTS, FINGERTIP_RATE, SUBCOUNTS
from firstcontact.core.physics import MOST
from firstcontact.jobs import Runner
from firstcontact.models import Touches
from firstcontact.models.rig.rigs import Rig, spectra
from firstcontact.models.values import Values
from firstcontact.signal import samples_in
from firstcontact.twin import BLOCKS
from firstcontact.twin.draw import draw_offset
from firstcontact_lab.rigs import (
    FAMILIES,
    HARDEST,
    SOFTEST,
    Day,
    RandomObject,
    RandomRig,
    Rng,
    draw_block,
    draw_day,
    draw_object,
    draw_rig,
    touch,
)

#: Largest placement error of a contact in samples, and mean and standard deviation of the error, as
#: for the detectors on the twin.
MARGIN = 8
PLACED = (2.0, 1.2)
#: The same for contacts that a copper strip finds, as on one rig in ``STRIPPED``.
STRIP, STRIPPED = (0.0, 0.5), 4
#: Range of the number of block pinches of each Shore A level in a context, without its upper end.
CONTEXT = (4, 20)
#: Number of random objects to predict, and number of pinches of each object and of each block.
THINGS, ASKED = 24, 2
#: Number of contexts of a rig: one from all its block pinches, the other from some of them.
CONTEXTS = 2
#: Share of rigs whose blocks have the Shore A of the paper's blocks.
PAPER = 0.6
_RATE = FINGERTIP_RATE
_BEFORE, _AFTER = samples_in(Touches.BEFORE, _RATE), samples_in(Touches.LONGEST, _RATE)


@dataclass(frozen=True, slots=True, eq=False)
class Examples:
    """Simulated contacts to predict, and the contexts of their rigs.

    A context is what the network knows of a rig, from pinches of blocks.
    """

    signals: NDArray[np.int16]
    shore_a: Values
    radii: Values
    speeds: Values
    object_ids: NDArray[np.intp]
    heard: NDArray[np.float32]
    rigs: NDArray[np.intp]
    tokens: NDArray[np.float32]
    levels: NDArray[np.intp]
    general: NDArray[np.float32]
    scale: Values
    has_strips: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.signals)


def joined(parts: Sequence[Examples]) -> Examples:
    offsets = np.cumsum([0, *(len(part.tokens) for part in parts)])
    arrays = {f.name: [getattr(part, f.name) for part in parts] for f in fields(Examples)}
    arrays["rigs"] = [rigs + offset for rigs, offset in zip(arrays["rigs"], offsets, strict=False)]
    return Examples(**{name: np.concatenate(several) for name, several in arrays.items()})


def volts(signals: NDArray[np.int16]) -> NDArray[np.float32]:
    return signals.astype(np.float32) * np.float32(ADC_VOLTS / (ADC_COUNTS * SUBCOUNTS))


def placing(rng: Rng, has_strips: NDArray[np.bool_]) -> NDArray[np.intp]:
    """Return random delays from a contact to where a strip or a detector places it, in samples.

    ``has_strips`` is True for the entries that a strip places.
    """
    mean, deviation = np.where(has_strips[:, None], STRIP, PLACED).T
    drawn = np.round(mean + deviation * rng.standard_normal(len(mean))).astype(np.intp)
    out: NDArray[np.intp] = np.clip(drawn, -MARGIN, MARGIN)
    return out


@dataclass(frozen=True, slots=True, eq=False)
class _Drawn:
    """Simulated pinches of one rig: of blocks with known Shore A, and of objects to predict."""

    context: tuple[NDArray[np.int16], Values]
    levels: Values
    signals: NDArray[np.int16]
    objects: list[RandomObject]
    numbers: NDArray[np.intp]
    speeds: Values
    has_strips: bool
    rng: Rng


def rig_examples(number: int, seed: int, family: str = "", again: int = 0) -> Examples:
    """Simulate the training examples of rig ``number``.

    Equal arguments give equal examples. ``family`` changes the structure of the rig.
    """
    return _example_set(_drawn(number, seed, family, again))


def labelled_touches(
    number: int, seed: int, family: str = ""
) -> tuple[Touches, Values, Touches, Values]:
    """Simulate contacts of rig ``number`` with blocks and with objects.

    Return (contacts with blocks, Shore A of these, contacts with objects, Shore A of these).
    """
    d = _drawn(number, seed, family, 0)
    is_object = d.numbers >= 0
    shore_a = np.array([specimen.shore_a for specimen in d.objects])
    blocks, objects = (_touches(d, signals) for signals in (d.context[0], d.signals[is_object]))
    radii = np.array([specimen.parameters.radius for specimen in d.objects])[is_object]
    flat = np.where(radii > MOST / 1000, np.inf, np.nan)
    blocks = replace(blocks, radii=np.full(len(blocks), np.inf))
    return blocks, d.levels, replace(objects, radii=flat), shore_a[is_object]


def _drawn(number: int, seed: int, family_name: str, again: int) -> _Drawn:
    rng = np.random.default_rng([seed, number])
    family = FAMILIES[family_name] if family_name else None
    rig = draw_rig(rng)
    if family is not None:
        rig = family.rig(rig, rng)
    blocks = _blocks(rng)
    days = [draw_day(rng) for _ in range(rng.integers(1, 4))]
    context, levels = _context(rig, blocks, days, rng)
    asked_days = [days[-1], draw_day(rng), draw_day(rng)]
    signals, objects, numbers, speeds = [], [], [], []
    wanted: list[tuple[int, RandomObject]] = []
    for object_number in range(THINGS):
        specimen = draw_object(rng)
        if family is not None:
            specimen = family.change_object(specimen, rng)
        wanted.append((object_number, specimen))
    wanted += [(-1, draw_block(rng, s, rig.block_scatter)) for s in blocks]
    for object_number, specimen in wanted:
        same = asked_days[rng.integers(3)] if again else None
        for _ in range(again or ASKED):
            day = asked_days[rng.integers(3)] if same is None else same
            signal, speed = _touch(rig, day, specimen, rng)
            signals.append(signal)
            objects.append(specimen)
            numbers.append(object_number)
            speeds.append(speed)
    return _Drawn(
        context,
        levels,
        np.array(signals),
        objects,
        np.array(numbers),
        np.array(speeds),
        number % STRIPPED == 0,
        rng,
    )


def _blocks(rng: Rng) -> list[float]:
    if rng.random() < PAPER:
        return [kind.shore_a for kind in BLOCKS]
    return sorted(float(s) for s in rng.uniform(SOFTEST, HARDEST, rng.integers(3, Rig.LEVELS)))


def _touch(
    rig: RandomRig, day: Day, specimen: RandomObject, rng: Rng
) -> tuple[NDArray[np.int16], float]:
    more = MARGIN / _RATE
    signal, speed = touch(rig, day, specimen, rng, Touches.BEFORE + more, Touches.LONGEST + more)
    return signal, speed


def _context(
    rig: RandomRig, blocks: list[float], days: list[Day], rng: Rng
) -> tuple[tuple[NDArray[np.int16], Values], Values]:
    """Simulate a rig's pinches of blocks. Return ((signals, closing speeds in m/s), Shore A)."""
    each = int(rng.integers(*CONTEXT))
    signals, speeds, levels = [], [], []
    for shore_a in blocks:
        specimens = [draw_block(rng, shore_a, rig.block_scatter) for _ in range(rng.integers(1, 4))]
        for _ in range(each):
            day = days[rng.integers(len(days))]
            signal, speed = _touch(rig, day, specimens[rng.integers(len(specimens))], rng)
            signals.append(signal)
            speeds.append(speed)
            levels.append(shore_a)
    return (np.array(signals), np.array(speeds)), np.array(levels)


def _touches(d: _Drawn, signals: NDArray[np.int16]) -> Touches:
    cut, valid, rng = [], [], d.rng
    shortest, longest = Touches.lengths(_RATE)
    places = placing(rng, np.full(len(signals), d.has_strips))
    for signal, late in zip(volts(signals), places, strict=True):
        signal_cut = Touches.cut_signal(signal, _BEFORE + MARGIN + int(late), _RATE)
        if signal_cut is None:  # the signal is constant
            signal_cut = np.zeros(_BEFORE + _AFTER, np.float32)
        cut.append(signal_cut)
        second = round(draw_offset(rng) * _RATE) - int(late)
        valid.append(min(max(second, shortest), longest))
    return Touches.from_signals(np.array(cut), np.array(valid), np.full(len(cut), -1), _RATE)


def _example_set(d: _Drawn) -> Examples:
    (blocks, block_speeds), shore_a, rng = d.context, d.levels, d.rng
    n = len(d.signals)
    tokens = np.zeros((1, CONTEXTS, len(Rig.STAGES), Rig.LEVELS, Rig.TOKEN), np.float32)
    levels = np.zeros((1, CONTEXTS), np.intp)
    general = np.zeros((1, CONTEXTS, Rig.GENERAL), np.float32)
    scale = np.zeros((1, CONTEXTS, 2))
    heard = np.zeros((n, CONTEXTS, HINTS), np.float32)
    queries = _touches(d, d.signals)
    sounds = spectra(queries.signals, _RATE)
    for place in range(CONTEXTS):
        rows = _subset(shore_a, 1.0 if place == 0 else float(rng.uniform(0.2, 0.8)), rng)
        rig = Rig.fit(_touches(d, blocks[rows]), shore_a[rows])
        count = rig.tokens.shape[1]
        tokens[0, place, :, :count] = rig.tokens
        levels[0, place] = count
        general[0, place] = rig.general
        scale[0, place] = rig.level, rig.sign
        assert rig.pitch is not None
        speed, alike = rig.pitch.listen(sounds)
        heard[:, place] = facts(speed, alike, np.full(n, np.nan))
    return Examples(
        signals=d.signals,
        shore_a=np.array([specimen.shore_a for specimen in d.objects]),
        radii=np.array([specimen.parameters.radius for specimen in d.objects]),
        speeds=np.log(d.speeds / np.median(block_speeds)),
        object_ids=d.numbers,
        heard=heard,
        rigs=np.zeros(n, np.intp),
        tokens=tokens,
        levels=levels,
        general=general,
        scale=scale,
        has_strips=np.array([d.has_strips]),
    )


def _subset(shore_a: Values, share: float, rng: Rng) -> NDArray[np.intp]:
    """Return the indices of a random share of the pinches of each Shore A.

    At least two pinches of each Shore A are included.
    """
    chosen = []
    for level in np.unique(shore_a):
        members = rng.permutation(np.flatnonzero(shore_a == level))
        chosen.append(members[: max(2, round(share * len(members)))])
    return np.sort(np.concatenate(chosen))


def facts(speed: Values, alike: Values, radii: Values) -> NDArray[np.float64]:
    """Return closing speeds and object radii as inputs of the network, shape (n, HINTS).

    ``speed`` is ln(speed / usual speed of the rig), and ``alike`` the confidence in it. ``radii``
    are in m, and NaN if unknown.
    """
    believed = alike > touch_constants().believed
    has_radius = ~np.isnan(radii)
    with np.errstate(divide="ignore"):
        curvature = np.log1p(touch_constants().tip / np.where(has_radius, radii, np.inf))
    return np.stack(
        [
            np.where(believed, np.clip(speed, -1.0, 1.0), 0.0) * 4,
            believed,
            alike,
            has_radius,
            np.where(has_radius, curvature, 0.0),
        ],
        axis=1,
    )


#: Version of examples and trainings, raised when rigs, objects, stored values or batches change.
#: Older files are not used.
DRAWN = 4
RIGS_PER_FILE = 50


def example_set(
    folder: Path, first: int, rigs: int, seed: int, runner: Runner, again: int = 0
) -> Examples:
    """Return the examples of ``rigs`` random rigs, numbered from ``first`` on.

    Examples that already exist in ``folder`` are read, not simulated again.
    """
    folder.mkdir(parents=True, exist_ok=True)
    parts = [
        (at, min(RIGS_PER_FILE, first + rigs - at))
        for at in range(first, first + rigs, RIGS_PER_FILE)
    ]
    kind = f"rigs-again{again}" if again else "rigs"
    files = [folder / f"{kind}-v{DRAWN}-{seed}-{at}-{n}.safetensors" for at, n in parts]
    missing = [part for part, file in zip(parts, files, strict=True) if not file.exists()]
    made = iter(runner.stream(_make_part, missing, seed, again))
    out: list[Examples] = []
    for file in files:
        if not file.exists():
            _write_part(file, next(made))
        out.append(_read_part(file))
    return joined(out)


def _make_part(part: tuple[int, int], seed: int, again: int) -> Examples:
    first, rigs = part
    numbers = range(first, first + rigs)
    return joined([rig_examples(number, seed, again=again) for number in numbers])


def _write_part(file: Path, examples: Examples) -> None:
    arrays = {f.name: np.ascontiguousarray(getattr(examples, f.name)) for f in fields(Examples)}
    with replacing(file) as temporary:
        temporary.write_bytes(save(arrays))


def _read_part(file: Path) -> Examples:
    return Examples(**load_file(file))
