"""Taps on a fingertip, and the verdicts of the self-test of two fingertips.

Each limit follows from the circuit, the mechanics or the timing of a pinch. The numbers of the
circuit are in ``docs/results/circuit.json``.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from firstcontact.collect.calibration import ALIKE, FACTOR, LEAST, WEAK
from firstcontact.core import ChannelKind, Finger, Layout, finger_name
from firstcontact.core.layout import ADC_COUNTS, ADC_VOLTS, PIEZO_OFFSET_VOLTS

Volts = NDArray[np.float64]

#: Share of the converter's range from which on a tap is clipped. The device's smoothing keeps short
#: peaks below the rail.
CLIPPED = 0.9
#: Duration of a tap, s before and after its begin, and least time between the begins of two taps.
BEFORE, AFTER = 0.02, 0.06
APART = 0.2
#: Parts of a tap whose vibration is compared, s after its begin.
LOUD, TAIL = (0.0, 0.004), (0.008, 0.020)
#: Time between their middles, s.
BETWEEN = (sum(TAIL) - sum(LOUD)) / 2
#: Share of the peak that counts as the first swing. A tool touches softly before it pushes.
SWING = 0.25
#: Least vibration of a tap, as a multiple of the noise, at which its decay can be measured.
CLEAR = 5.0


class Tap(NamedTuple):
    volts: Volts
    """Vibration columns around the tap, V from the level at rest, shape (samples, columns)."""
    is_clipped: bool


class TapMeasures(NamedTuple):
    """Measurements of several taps on one finger. Arrays have a value per vibration column."""

    number: int
    clipped: int
    peak: Volts
    """Median peak, V. Clipped taps count if all are clipped."""
    loudness: Volts
    """Median peak up to the first clipped tap, V. Later taps are gentler on request."""
    swing: Volts
    """Median sign of the first swing."""
    decay: Volts
    """Time constant of the vibration above a few hundred hertz, s; NaN if the taps are too weak."""


def find_taps(layout: Layout, x: Volts, rest: Volts) -> list[Tap]:
    """Find all complete taps on any finger.

    ``x`` are the vibration columns, and ``rest`` the same ones at rest, V, shape (samples,
    columns).
    """
    offset = np.median(rest, axis=0)
    limit = np.maximum(LEAST, FACTOR * rest.std(axis=0))
    before, after, apart = (round(t * layout.rate) for t in (BEFORE, AFTER, APART))
    loud = np.flatnonzero((np.abs(x - offset) > limit).any(axis=1))
    rail = np.array([PIEZO_OFFSET_VOLTS if c.unit == "V" else 1.0 for c in layout.vibration])
    taps: list[Tap] = []
    last = -apart
    for begin in map(int, loud):
        if begin - last < apart:
            continue
        last = begin
        if begin >= before and begin + after <= len(x):
            piece = x[begin - before : begin + after]
            is_clipped = bool((np.abs(piece) > CLIPPED * rail).any())
            taps.append(Tap(piece - offset, is_clipped))
    return taps


def measure_taps(layout: Layout, taps: Sequence[Tap], rest: Volts) -> TapMeasures:
    """Measure the peak, decay and loudness of taps in each vibration column.

    ``rest`` are these columns at rest, V, shape (samples, columns).
    """
    clipped = sum(t.is_clipped for t in taps)
    usable = [t.volts for t in taps if not t.is_clipped] or [t.volts for t in taps]
    columns = rest.shape[1]
    if not usable:
        nothing = np.zeros(columns)
        return TapMeasures(0, 0, nothing, nothing, nothing, np.full(columns, math.nan))
    volts = np.array(usable)
    peaks = np.abs(volts).max(axis=1)
    first = (np.abs(volts) >= SWING * peaks[:, None]).argmax(axis=1)
    end = next((k + 1 for k, tap in enumerate(taps) if tap.is_clipped), len(taps))
    before = [np.abs(tap.volts).max(axis=0) for tap in taps[:end]]
    swings = np.sign(np.take_along_axis(volts, first[:, None], axis=1)[:, 0])
    return TapMeasures(
        len(taps), clipped, np.median(peaks, axis=0), np.median(before, axis=0),
        np.sign(swings.sum(axis=0)), _fading_times(layout, usable, rest),
    )  # fmt: skip


def _fading_times(layout: Layout, taps: Sequence[Volts], rest: Volts) -> Volts:
    """Return the time constant of the decay of taps in each vibration column, s, shape (columns,).

    It is NaN if the taps are too weak. ``rest`` are the columns at rest. Second differences
    suppress the slow swing of the finger (59 Hz).
    """
    noise = np.diff(rest, 2, axis=0).var(axis=0)

    def power(part: tuple[float, float]) -> Volts:
        first, end = (round((BEFORE + t) * layout.rate) for t in part)
        pieces = np.array([np.diff(t[first - 2 : end], 2, axis=0) for t in taps])
        return np.asarray((pieces**2).mean(axis=(0, 1)))

    loud, tail = power(LOUD), power(TAIL)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.sqrt(np.clip(tail - noise, 0.0, None) / np.maximum(loud - noise, 1e-30))
        decay = np.where(ratio < 1, BETWEEN / -np.log(ratio), math.inf)
    return np.where(loud > CLEAR**2 * noise, decay, math.nan)


#: Step of the converter, V.
STEP = ADC_VOLTS / ADC_COUNTS
#: Largest offset, V: two 1 % resistors make 16.5 mV, the amplifier at most 1.2 steps, and the
#: converter 2 (assumption). A BAT54S as clamp makes 44 steps.
OFFSET = 0.0165 + (1.2 + 2) * STEP
#: Largest noise, V RMS. Converter and amplifier make less than one step.
NOISE = 2 * STEP
#: Largest amplitude of hum, V: half of what counts as a tap.
HUM = LEAST / 2
#: Largest drift in five minutes, V: the largest offsets of amplifier and converter (assumption).
DRIFT = (1.2 + 2) * STEP
DRIFT_TIME = 300.0
#: Longest delay of 99 % of the samples, s. The second finger touches 16 ms after the first.
DELAY = 0.016
#: Longest decay of a tap, s. That of the mount's design is 2 m / c = 1.6 ms. A soft tool stays on
#: the pad for longer, which makes up to 4.7 ms in simulated hands.
DECAY = 0.005
#: Number of clipped taps, in spite of as many requests to tap more gently, that prove a fault. One
#: is enough in a finger that is also ``ALIKE`` times as loud as the other.
CLIPPED_TAPS = 5
#: Factor by which the wrong finger must be louder.
SWAPPED = 2.0
MAINS = (50.0, 60.0)
#: Least rise of a pressed taxel, V: a tenth of what 2 N give with the least conductive sheets.
RISE = 0.05
#: Largest difference between two connected lines, as a share of their rise. The pressed place
#: bears about half of the force, and each other place a tenth.
SAME = 0.25
#: Rows and columns of the fingertip's array. The number of a taxel is 2 * row + column.
ROWS, COLUMNS = 3, 2
#: Remedy for the fault that each check finds.
REMEDIES = {
    "offset": "Measure 1.65 V at the reference. Use a BAV199 as clamp. Compare the resistors with "
    "the table of parts.",
    "noise": "Check the capacitor at the amplifier's supply. Keep the motors' current out of its "
    "ground.",
    "hum": "Shorten or shield the disc's wires, and ground the hand.",
    "fingers": "Exchange the cables of the two fingertips.",
    "sensitivity": "Tap both fingers alike, and harder. Check the disc's wires and its glue, and "
    "that the board touches nothing but the post.",
    "clipping": "Tap as if the pencil fell 2 mm. Compare R13 and R14, or R23 and R24, with the "
    "table of parts. A disc in hard glue clips, too: it must lie in silicone.",
    "polarity": "The disc lies on its wrong face: glue it in again, positive face to the post.",
    "places": "The disc lies in hard glue, or its silicone has a gap. Measure its capacitance: in "
    "hard glue it is a tenth less than that of the free disc. Glue it in again with soft silicone.",
    "rattle": "Tighten the mount's screws. Check the glue between board, disc and post.",
    "force array": "Unplug now: connected rows overload pins. Check the cable and the solder "
    "joints of these lines, and that the sheet lies flat. Then press each of the six places.",
    "drift": "Use a BAV199 as clamp. Clean flux from the amplifier's input.",
    "jitter": "Leave out hubs. Close programs that keep the computer busy.",
    "lost samples": "Change the cable, and leave out hubs.",
}


class Verdict(NamedTuple):
    check: str
    finger: str
    measured: str
    limit: str
    is_good: bool

    @property
    def remedy(self) -> str:
        return REMEDIES[self.check]


@dataclass
class Measured:
    """Measurements from all steps of a self-test, in physical units.

    ``rest`` and ``presses`` are samples of all columns of the layout, at rest and while a person
    presses a finger. ``taps`` and ``corners`` are taps on the middle and the corners of each pad.
    ``drift`` has the mean of each vibration column in each second. ``lost`` and ``samples`` count
    lost and received samples.
    """

    layout: Layout
    rest: Volts
    taps: dict[Finger, list[Tap]] = field(default_factory=dict)
    corners: dict[Finger, list[Tap]] = field(default_factory=dict)
    presses: dict[Finger, Volts] = field(default_factory=dict)
    drift: Volts = field(default_factory=lambda: np.zeros((0, 0)))
    #: Delay of each sample, s; None if the source does not run in real time.
    delays: Volts | None = None
    lost: int = 0
    samples: int = 0


def judge(measured: Measured) -> list[Verdict]:
    """Return a verdict for each check that was measured."""
    verdicts = [*_rest_verdicts(measured), *_touch_verdicts(measured), *_drift_verdicts(measured)]
    if measured.delays is not None and len(measured.delays):
        late = float(np.percentile(measured.delays, 99))
        verdicts.append(_limit_verdict("jitter", "", late, DELAY, "s for 99 % of the samples"))
    count = f"{measured.lost} of {measured.lost + measured.samples}"
    verdicts.append(Verdict("lost samples", "", count, "0", measured.lost == 0))
    return verdicts


def _limit_verdict(check: str, finger: str, value: float, limit: float, unit: str) -> Verdict:
    """Return the verdict of a check that requires ``value`` to be from -``limit`` to ``limit``.

    ``unit`` is the unit of both, such as "V".
    """
    words = f"{1e3 * value:.1f} m{unit}", f"{1e3 * limit:.1f} m{unit}"
    return Verdict(check, finger, *words, bool(abs(value) <= limit))


def _rest_verdicts(measured: Measured) -> Iterator[Verdict]:
    layout = measured.layout
    x = measured.rest[:, layout.columns(ChannelKind.VIBRATION)]
    offset = np.median(x, axis=0)
    hum = np.zeros(x.shape[1])
    for mains in MAINS:
        turns = 2j * np.pi * mains / layout.rate * np.outer(np.arange(len(x)), (1, 2, 3))
        lines = 2 * np.exp(-turns).T @ x / len(x)
        x = x - (np.exp(turns) @ lines).real
        hum = np.maximum(hum, np.sqrt((np.abs(lines) ** 2).sum(axis=0)))
    part = max(2, round(0.1 * layout.rate))
    parts = x[: len(x) // part * part].reshape(-1, part, x.shape[1])
    # The median ignores parts in which a person moved.
    noise = np.median(parts.std(axis=1), axis=0)
    for k, channel in enumerate(layout.vibration):
        name = finger_name(channel.finger)
        yield _limit_verdict("offset", name, offset[k], OFFSET, "V")
        yield _limit_verdict("noise", name, noise[k], NOISE, "V RMS")
        yield _limit_verdict("hum", name, hum[k], HUM, "V")


def _drift_verdicts(measured: Measured) -> Iterator[Verdict]:
    if len(measured.drift) < 3:
        return
    slope = np.polyfit(np.arange(len(measured.drift)), measured.drift, 1)[0] * DRIFT_TIME
    for channel, change in zip(measured.layout.vibration, slope, strict=True):
        yield _limit_verdict(
            "drift", finger_name(channel.finger), change, DRIFT, "V in five minutes"
        )


def _touch_verdicts(measured: Measured) -> Iterator[Verdict]:
    layout = measured.layout
    still = measured.rest[:, layout.columns(ChannelKind.VIBRATION)]
    taps = {f: measure_taps(layout, t, still) for f, t in measured.taps.items()}
    corners = {f: measure_taps(layout, t, still) for f, t in measured.corners.items()}
    vibration = {c.finger: k for k, c in enumerate(layout.vibration)}
    rises = {
        f: {g: _rise_above_rest(measured, x, g) for g in Finger}
        for f, x in measured.presses.items()
    }
    is_swapped = _are_fingers_swapped({
        f: (float(t.peak[vibration[f]]), float(t.peak[vibration[f.other]])) for f, t in taps.items()
    }) or _are_fingers_swapped({
        f: (float(r[f].max(initial=0)), float(r[f.other].max(initial=0))) for f, r in rises.items()
    })  # fmt: skip
    if len(taps) == len(Finger) or len(rises) == len(Finger):
        words = "exchanged" if is_swapped else "as named"
        yield Verdict("fingers", "", words, "as named", not is_swapped)
    column = {f: vibration[f.other if is_swapped else f] for f in taps}
    loudest = max((float(t.peak[column[f]]) for f, t in taps.items()), default=0.0)
    quietest = min((float(t.loudness[column[f]]) for f, t in taps.items()), default=0.0)
    # A finger with taps that are too weak is no measure of the other one's gain.
    quietest = quietest if quietest >= WEAK else math.inf
    for f, t in taps.items():
        yield from _tap_verdicts(finger_name(f), t, column[f], quietest, loudest)
        if f in corners:
            yield from _compare_corners(finger_name(f), t, corners[f], column[f])
    for f, r in rises.items():
        messages = array_faults(r[f.other if is_swapped else f])
        words = "; ".join(messages) or "all taxels rise"
        yield Verdict("force array", finger_name(f), words, "all taxels rise", not messages)


def has_array_faults(measured: Measured, finger: Finger) -> bool:
    return bool(array_faults(_rise_above_rest(measured, measured.presses[finger], finger)))


def _rise_above_rest(measured: Measured, x: Volts, finger: Finger) -> Volts:
    """Return the rise of each force cell of a finger above its voltage at rest, V.

    ``x`` are samples of all columns. The result has the shape (samples, cells).
    """
    columns = measured.layout.columns(ChannelKind.FORCE, finger)
    return np.asarray(x[:, columns] - measured.rest[:, columns].mean(axis=0))


def _are_fingers_swapped(levels: dict[Finger, tuple[float, float]]) -> bool:
    """Return True if each finger's signal is larger in the channel of the other finger.

    ``levels`` has two signals, V, for each finger that was tapped or pressed: the one in its own
    channel, and the one in the other finger's channel. Return False unless it has both fingers.
    """
    return len(levels) == len(Finger) and all(
        other > max(SWAPPED * own, LEAST) for own, other in levels.values()
    )


def _tap_verdicts(
    name: str, taps: TapMeasures, column: int, quietest: float, loudest: float
) -> Iterator[Verdict]:
    peak, decay = float(taps.peak[column]), float(taps.decay[column])
    least = max(WEAK, loudest / ALIKE)
    yield Verdict("sensitivity", name, f"{peak:.3f} V a tap", f"{least:.3f} V", peak >= least)
    count = f"{taps.clipped} of {taps.number} taps"
    is_louder = taps.loudness[column] > ALIKE * quietest
    most = 0 if is_louder else CLIPPED_TAPS - 1
    yield Verdict("clipping", name, count, f"{most} taps", taps.clipped <= most)
    if peak >= LEAST:
        is_positive = bool(taps.swing[column] > 0)
        words = "positive" if is_positive else "negative"
        yield Verdict("polarity", name, f"a push is {words}", "positive", is_positive)
    if not math.isnan(decay):
        verdict = _limit_verdict("rattle", name, decay, DECAY, "s decay")
        yield verdict if decay else verdict._replace(measured="taps fade into the noise")


def _compare_corners(
    name: str, middle: TapMeasures, corners: TapMeasures, column: int
) -> Iterator[Verdict]:
    """Yield a verdict that compares taps on a pad's corners with taps on its middle.

    Yield nothing without taps on corners, or if all taps are too weak. ``name`` is the finger's
    name, and ``column`` the index of its vibration column.
    """
    sizes = float(middle.peak[column]), float(corners.peak[column])
    if not corners.number or max(sizes) < WEAK:
        return
    ratio = sizes[1] / max(sizes[0], STEP) * (middle.swing * corners.swing)[column]
    words = f"corners {ratio:+.1f} times the middle"
    is_alike = 1 / ALIKE <= ratio <= ALIKE
    yield Verdict("places", name, words, f"{1 / ALIKE:.1f} to {ALIKE:g} times", bool(is_alike))


def array_faults(rises: NDArray[np.float64]) -> list[str]:
    """Return a sentence for each fault of a finger's force array.

    ``rises`` is the rise of each force cell above rest, V, shape (samples, cells).
    """
    highest = rises.max(axis=0)
    if highest.max() < RISE:
        return ["no taxel rises"]
    if highest.size != ROWS * COLUMNS:
        return [f"taxel {k} does not rise" for k in np.flatnonzero(highest < RISE)]
    dead = (highest < RISE).reshape(ROWS, COLUMNS)
    grid = rises.reshape(-1, ROWS, COLUMNS)
    messages = [f"row {r} is open" for r in range(ROWS) if dead[r].all()]
    messages += [f"column {c} is open" for c in range(COLUMNS) if dead[:, c].all()]
    messages += [
        f"taxel {COLUMNS * r + c} does not rise"
        for r, c in np.argwhere(dead)
        if not dead[r].all() and not dead[:, c].all()
    ]
    for name, lines in (("rows", np.moveaxis(grid, 1, 0)), ("columns", np.moveaxis(grid, 2, 0))):
        messages += [
            f"{name} {a} and {b} are connected"
            for a, b in combinations(range(len(lines)), 2)
            if _are_connected(lines[a], lines[b])
        ]
    return messages


def _are_connected(a: NDArray[np.float64], b: NDArray[np.float64]) -> bool:
    """Return True if two rows (or two columns) of a force array always rise by the same voltage.

    ``a`` and ``b`` are the rises of their cells, V, shape (samples, cells).
    """
    rise = np.maximum(a, b).max(axis=0)
    return bool((rise > RISE).all() and (np.abs(a - b).max(axis=0) < SAME * rise).all())
