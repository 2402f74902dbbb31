"""Simulated pinches with both fingers' contacts and the squeeze, and laws that combine them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from msgspec import structs
from numpy.typing import NDArray

from firstcontact.core import (
    ArgumentError,
    ChannelKind,
    Contact,
    Dataset,
    Label,
    Pinch,
    Record,
    Role,
)
from firstcontact.core.layout import FINGERTIP_RATE
from firstcontact.models import Touches
from firstcontact.models.interval import SHORE_A
from firstcontact.twin import BLOCKS, CONDITIONS, draw_pinch
from firstcontact.twin.draw import PinchDraw, draw_specimen, generator
from firstcontact.twin.drive import Positions
from firstcontact.twin.mechanics import CONTACT_FORCE, FACE, INDENTATION, FingerParameters
from firstcontact.twin.objects import EVERYDAY_OBJECTS, TwinObject
from firstcontact.twin.pinch import PinchJob, excerpt, simulate_pinches
from firstcontact_lab.rigs import RIG_SPREAD, RandomRig, draw_object, draw_rig
from firstcontact_lab.study.random_rigs import DELAY, EVERYDAY, MARGIN, OWN, RANDOM, draw_delay

Values = NDArray[np.float64]
#: Times after the first contact at which the squeeze is read, ms.
SQUEEZES = (50, 100, 200, 500)
#: Simulated time before the first contact, s, and in total.
BEFORE = 0.045
LENGTH = BEFORE + 1e-3 * SQUEEZES[-1] + 0.005
#: Signal of the second finger that is used, s.
SECOND = 0.008
#: Shortest squeeze that is read, s, and so the longest time between the contacts.
SHORTEST = 0.015
LONGEST_GAP = 1e-3 * SQUEEZES[0] - SHORTEST
#: Time over which positions and forces are averaged, as a share of the squeeze, and at most, s.
SHARE, LONGEST = 0.1, 0.050
#: Smallest travel, m, and smallest force, V, so that their logarithms exist.
LEAST_TRAVEL, LEAST_FORCE = 2e-4, 0.02
#: Regularisation of the calibration of a squeeze.
RIDGE = 0.3
#: Share of the intervals that should hold the true value.
LEVEL = 0.9


@dataclass(frozen=True)
class Sizes:
    """Number of pinches of each block, of each everyday object, and of random objects."""

    blocks: int = 16
    objects: int = 6
    random: int = 40


class _Sensors(Positions):
    """Position sensor of the drives. It also records the exact force and compression."""

    compression: Values
    force: Values

    def add(self, motion: Values, first_sample: int) -> None:
        super().add(motion, first_sample)
        self.compression = (np.nan_to_num(motion[..., INDENTATION]) + motion[..., FACE]).sum(1)
        self.force = motion[..., CONTACT_FORCE].mean(1)


@dataclass(frozen=True, slots=True, eq=False)
class Grasps:
    """Pinches of one hand: contacts of both fingers, and features of the squeeze.

    The features are those at the times ``SQUEEZES``, ms after the first contact.
    """

    first: Touches
    second: Touches
    #: Time between the contacts, s, shape (n,).
    gaps: Values
    #: Features by the hand's sensors and by exact ones, (times, n, features).
    squeezes: Values
    exact: Values
    shore_a: Values
    uses: NDArray[np.str_]
    sessions: NDArray[np.str_]
    #: Number of pinches left out: the second finger touches within 2 ms, or too late for a squeeze.
    left_out: int


def grasps(seed: int, condition: str, sizes: Sizes, *, is_random: bool = False) -> Grasps:
    """Simulate a hand that pinches blocks, everyday objects and random objects.

    It is the twin's hand, or with ``is_random`` a random one as in pre-training.
    """
    rng = generator(seed, condition, "grasps")
    jobs = list(_jobs(seed, condition, sizes, rng, is_random))
    shortest, longest = Touches.lengths(_RATE)[0], round(LONGEST_GAP * _RATE)
    kept = []
    for job, pinch in zip(jobs, simulate_pinches(jobs, LENGTH), strict=True):
        placed = [_placed(contact, rng) for contact in pinch.truth]
        if len(placed) < 2 or not shortest <= placed[1].sample - placed[0].sample <= longest:
            continue
        assert isinstance(job.positions, _Sensors)
        found = replace(pinch, truth=tuple(placed))
        kept.append((found, *_squeezes(found, job.positions)))
    pinches, squeezes, exact = zip(*kept, strict=True)
    first, second = (_touches(pinches, place) for place in (0, 1))
    labels = [pinch.label for pinch in pinches]
    return Grasps(
        first,
        second,
        np.array([pinch.offset for pinch in pinches]),
        np.stack(squeezes, axis=1),
        np.stack(exact, axis=1),
        np.array([label.shore_a for label in labels]),
        np.array([label.session.rpartition("-")[0] for label in labels]),
        np.array([label.session for label in labels]),
        len(jobs) - len(kept),
    )


_RATE = FINGERTIP_RATE


def _jobs(
    seed: int, name: str, sizes: Sizes, rng: np.random.Generator, is_random: bool
) -> Iterator[PinchJob]:
    condition = CONDITIONS[name]
    hand = draw_rig(rng) if is_random else None
    drawn = [_random_object(rng, number) for number in range(sizes.random)]
    for use, kinds, each, sessions in (
        (OWN, BLOCKS, sizes.blocks, 8),
        (EVERYDAY, EVERYDAY_OBJECTS, sizes.objects, 2),
        (RANDOM, drawn, 1, 1),
    ):
        copies = condition.specimens_per_block if use == OWN else 1
        for kind in kinds:
            for number in range(each):
                session, key = f"{use}-{number % sessions + 1}", f"{kind.name} {number}"
                copy = number // sessions % copies
                specimen = draw_specimen(seed, condition, kind, copy)
                draw = draw_pinch(seed, condition, session, specimen, key)
                draw = excerpt(draw if hand is None else _with_hand(draw, hand), BEFORE)
                label = Label(
                    kind.name, kind.shore_a, session=session, role=kind.role, shape=kind.shape
                )
                sensors = _Sensors(generator(seed, name, "positions", session, key))
                yield PinchJob(draw, label, 0, sensors)


def _random_object(rng: np.random.Generator, number: int) -> TwinObject:
    drawn = draw_object(rng)
    return TwinObject(f"object {number}", drawn.shore_a, Role.TEST, drawn.parameters, 0.0)


def _with_hand(draw: PinchDraw, rig: RandomRig) -> PinchDraw:
    """Return the pinch with its fingers scaled to those of a random rig.

    The factor of each parameter is that of the rig over the nominal one.
    """
    usual = FingerParameters()

    def changed(finger: FingerParameters) -> FingerParameters:
        names = (*RIG_SPREAD, "gain")
        factors = {name: getattr(rig.finger, name) / getattr(usual, name) for name in names}
        values = {name: getattr(finger, name) * factor for name, factor in factors.items()}
        return finger._replace(**values, pad_confinement=rig.finger.pad_confinement)

    index, thumb = draw.fingers
    return replace(draw, fingers=(changed(index), changed(thumb)))


def _placed(contact: Contact, rng: np.random.Generator) -> Contact:
    """Return the contact as a detector places it: later by a random number of samples."""
    return replace(
        contact, sample=contact.sample + draw_delay(rng, DELAY), decided=contact.sample + MARGIN
    )


def _touches(pinches: Sequence[Pinch], place: int) -> Touches:
    """Return the contacts of pinches with their signals: the first (``place`` 0) or second (1)."""
    contacts = [pinch.truth[place] for pinch in pinches]
    cut = Dataset(tuple(replace(pinch, truth=pinch.truth[place:]) for pinch in pinches))
    touches, rows = Touches.cut(cut, contacts)
    assert len(rows) == len(pinches)
    return touches if place == 0 else touches.until(round(SECOND * _RATE))


def _squeezes(pinch: Pinch, sensors: _Sensors) -> tuple[Values, Values]:
    """Return the features of a squeeze twice: by the hand's sensors, and by exact ones."""
    first, second = (contact.sample for contact in pinch.truth)
    times, positions = np.array(sensors.since(-1.0)).T
    exact = []
    for ms in SQUEEZES:
        now = first + round(1e-3 * ms * _RATE)
        recent = slice(now - round(_window(now - second, LONGEST * _RATE)), now)
        compression = max(float(sensors.compression[recent].mean()), LEAST_TRAVEL)
        exact.append([np.log(max(float(sensors.force[recent].mean()), 0.1) / compression)])
    measured = [pinch_squeeze(pinch, times, positions, ms) for ms in SQUEEZES]
    return np.array(measured), np.array(exact)


def pinch_squeeze(pinch: Pinch, times: Values, positions: Values, ms: float) -> Values:
    """Return the features of a squeeze, ``ms`` after the first contact, by the hand's sensors.

    ``positions`` (m) are those of the hand at ``times`` (s from the pinch's first sample). A
    recording of a driven hand has them: ``pinch.group("hand")``. Raises ArgumentError without a
    second contact before ``ms``, or if the recording ends earlier.
    """
    rate = pinch.layout.rate
    if len(pinch.truth) != 2:
        raise ArgumentError(f"it has {len(pinch.truth)} contacts instead of two", "pinch")
    first, second = (contact.sample - pinch.first_sample for contact in pinch.truth)
    cells = pinch.layout.physical(pinch.data, pinch.layout.columns(ChannelKind.FORCE)).sum(axis=1)
    cells = cells - cells[:first].mean()
    now = (first + round(1e-3 * ms * rate)) / rate
    end = min(len(cells) / rate, float(times.max(initial=0.0)) + LONGEST)
    if not second / rate < now <= end:
        span = [f"{1e3 * (time - first / rate):.0f}" for time in (second / rate, end)]
        raise ArgumentError(f"expected {span[0]} (second contact) to {span[1]}, got {ms:g}", "ms")
    return squeeze_features(
        times, positions, np.arange(len(cells)) / rate, cells, second / rate, now
    )


def _window(squeezed: float, longest: float) -> float:
    """Return the time over which the end of a squeeze is averaged.

    ``squeezed`` is the time since the second contact. All times are in the same unit.
    """
    return min(SHARE * squeezed, longest)


FEATURES = ("largest travel", "travel", "force")


def squeeze_features(
    times: Values, positions: Values, every: Values, cells: Values, second: float, now: float
) -> Values:
    """Return the logarithms of largest travel, newest travel and newest force of a squeeze.

    ``positions`` are those of the drives at ``times``. ``cells`` is the sum of all force cells,
    less its value at rest, at the times ``every``. The squeeze lasts from ``second`` to ``now``.
    """
    window = _window(now - second, LONGEST)
    is_past = times <= now
    times, travel = times[is_past], positions[is_past] - np.interp(second, times, positions)
    newest = travel[times > now - window] if (times > now - window).any() else travel[-1:]
    force = cells[(every > now - max(window, 0.005)) & (every <= now)].mean()
    largest = travel[times >= second].max(initial=0.0)
    return np.log(
        [max(largest, LEAST_TRAVEL), max(newest.mean(), LEAST_TRAVEL), max(force, LEAST_FORCE)]
    )


@dataclass(frozen=True, slots=True, eq=False)
class SqueezeScale:
    """Calibration of squeezes on blocks: Shore A as a polynomial in the features of a squeeze."""

    middle: Values
    scale: Values
    weights: Values

    @classmethod
    def fit(cls, features: Values, shore_a: Values) -> Self:
        made = cls(features.mean(axis=0), features.std(axis=0) + 1e-9, np.zeros(0))
        inputs = made._inputs(features)
        penalty = RIDGE * np.eye(inputs.shape[1])
        penalty[0, 0] = 0.0
        weights = np.linalg.solve(inputs.T @ inputs + penalty, inputs.T @ shore_a)
        return replace(made, weights=np.asarray(weights, np.float64))

    def predict(self, features: Values) -> Values:
        return np.clip(self._inputs(features) @ self.weights, *SHORE_A)

    def evidence(self, features: Values) -> Values:
        """Return the predicted Shore A, then the standardised features, shape (1 + features, n)."""
        return np.vstack([self.predict(features), ((features - self.middle) / self.scale).T])

    def _inputs(self, features: Values) -> Values:
        z = (features - self.middle) / self.scale
        return np.column_stack([np.ones(len(z)), z, z[:, 0] ** 2])


class GraspLaw(Record, frozen=True, kw_only=True):
    """Linear correction of an estimate by later evidence, and the interval of the result.

    It is measured on hands and objects that are not scored. Evidence has the shape (n, inputs).
    """

    #: Means of the evidence, and correction for each unit above them, (inputs,).
    means: list[float]
    weights: list[float]
    #: Correction where all evidence is at its mean, Shore A.
    shift: float
    #: Half width of the interval, as a multiple of the estimate's spread.
    factor: float

    @classmethod
    def measure(
        cls, estimate: Values, spread: Values, evidence: Values, truth: Values, *, shifts: bool
    ) -> Self:
        """Measure the law on pinches of known Shore A, by least squares.

        Without ``shifts`` the mean of the estimates remains: their own bias is not corrected.
        """
        means, errors = evidence.mean(axis=0), truth - estimate
        shift = float(errors.mean()) if shifts else 0.0
        weights = np.linalg.lstsq(evidence - means, errors - errors.mean())[0]
        law = cls(means=means.tolist(), weights=weights.tolist(), shift=shift, factor=0.0)
        left = np.abs(law.value(estimate, evidence) - truth) / spread
        return structs.replace(law, factor=float(np.quantile(left, LEVEL)))

    def value(self, estimate: Values, evidence: Values) -> Values:
        corrections: Values = (evidence - np.array(self.means)) @ np.array(self.weights)
        return np.clip(estimate + self.shift + corrections, *SHORE_A)

    def predict(
        self, estimate: Values, spread: Values, evidence: Values
    ) -> tuple[Values, Values, Values]:
        """Return corrected estimates and the ends of their intervals, (n,) each."""
        value, half = self.value(estimate, evidence), self.factor * spread
        return value, np.clip(value - half, *SHORE_A), np.clip(value + half, *SHORE_A)
