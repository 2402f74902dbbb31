"""Simulated pinches with both fingers' contacts and the squeeze, and estimates that use them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from msgspec import structs
from numpy.typing import NDArray

from firstcontact.core import ChannelKind, Contact, Dataset, Label, Pinch, Record, Role
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
from firstcontact_lab.study.random_rigs import DELAY, MARGIN, draw_delay
from firstcontact_lab.study.scores import NORMAL

Values = NDArray[np.float64]
#: Times after the first contact at which the squeeze is read, ms.
SQUEEZES = (50, 100, 200, 500)
#: Simulated time before the first contact, s, and in total.
BEFORE = 0.045
LENGTH = BEFORE + 1e-3 * SQUEEZES[-1] + 0.005
#: Signal of the second finger that is used, s.
SECOND = 0.008
#: Shortest squeeze that is read, s.
SHORTEST = 0.015
#: Time over which positions and forces are averaged, as a share of the squeeze, and at most, s.
SHARE, LONGEST = 0.1, 0.050
#: Smallest travel, m, and smallest force, V, so that their logarithms exist.
LEAST_TRAVEL, LEAST_FORCE = 2e-4, 0.02
#: Regularisation of the calibration of a squeeze.
RIDGE = 0.3
#: Share of the intervals that should hold the true value.
LEVEL = 0.9
#: Uses of a pinch: blocks to learn from, and everyday and random objects to predict.
OWN, EVERYDAY, RANDOM = "own", "everyday", "random"


@dataclass(frozen=True)
class Sizes:
    """Numbers of pinches of each block and of each everyday object, and of random objects."""

    blocks: int = 16
    objects: int = 6
    random: int = 40


class _Sensors(Positions):
    """Position sensor of the drives that also keeps the exact force and compression."""

    compression: Values
    force: Values

    def add(self, motion: Values, first_sample: int) -> None:
        super().add(motion, first_sample)
        self.compression = (np.nan_to_num(motion[..., INDENTATION]) + motion[..., FACE]).sum(1)
        self.force = motion[..., CONTACT_FORCE].mean(1)


@dataclass(frozen=True, slots=True, eq=False)
class Grasps:
    """Pinches of one hand: both contacts, and features of the squeeze at ``SQUEEZES``."""

    first: Touches
    second: Touches
    #: Time between the contacts, s, shape (n,).
    gaps: Values
    #: Features by the hand's sensors and by exact ones, (times, n, features); NaN if too early.
    squeezes: Values
    exact: Values
    shore_a: Values
    uses: NDArray[np.str_]
    sessions: NDArray[np.str_]
    #: Number of pinches left out, because the second finger touches within 2 ms.
    too_short: int


def grasps(seed: int, condition: str, sizes: Sizes, *, is_random: bool = False) -> Grasps:
    """Simulate a hand that pinches blocks, everyday objects and random objects.

    With ``is_random`` the hand is drawn as those of the pretraining are, instead of the twin's.
    """
    rng = generator(seed, condition, "grasps")
    jobs = list(_jobs(seed, condition, sizes, rng, is_random))
    kept, too_short = [], 0
    for job, pinch in zip(jobs, simulate_pinches(jobs, LENGTH), strict=True):
        placed = [_placed(contact, rng) for contact in pinch.truth]
        if len(placed) < 2 or placed[1].sample - placed[0].sample < Touches.lengths(_RATE)[0]:
            too_short += 1
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
        too_short,
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
    """Return the pinch with fingers that differ from the twin's as this rig differs from it."""
    usual = FingerParameters()

    def changed(finger: FingerParameters) -> FingerParameters:
        names = (*RIG_SPREAD, "gain")
        factors = {name: getattr(rig.finger, name) / getattr(usual, name) for name in names}
        values = {name: getattr(finger, name) * factor for name, factor in factors.items()}
        return finger._replace(**values, pad_confinement=rig.finger.pad_confinement)

    index, thumb = draw.fingers
    return replace(draw, fingers=(changed(index), changed(thumb)))


def _placed(contact: Contact, rng: np.random.Generator) -> Contact:
    """Return the contact as a detector would place it: late, by a random number of samples."""
    return replace(
        contact, sample=contact.sample + draw_delay(rng, DELAY), decided=contact.sample + MARGIN
    )


def _touches(pinches: Sequence[Pinch], place: int) -> Touches:
    """Return the first (0) or second (1) contacts of pinches, with their signals."""
    contacts = [pinch.truth[place] for pinch in pinches]
    cut = Dataset(tuple(replace(pinch, truth=pinch.truth[place:]) for pinch in pinches))
    touches, rows = Touches.cut(cut, contacts)
    assert len(rows) == len(pinches)
    return touches if place == 0 else touches.until(round(SECOND * _RATE))


def _squeezes(pinch: Pinch, sensors: _Sensors) -> tuple[Values, Values]:
    """Return the features of a squeeze by the hand's sensors, and by exact ones."""
    first, second = (contact.sample for contact in pinch.truth)
    cells = pinch.layout.physical(pinch.data, pinch.layout.columns(ChannelKind.FORCE)).sum(axis=1)
    cells = cells - cells[:first].mean()
    times, positions = np.array(sensors.since(-1.0)).T
    every = np.arange(len(cells)) / _RATE
    measured = np.full((len(SQUEEZES), len(FEATURES)), np.nan)
    exact = np.full((len(SQUEEZES), 1), np.nan)
    for row, ms in enumerate(SQUEEZES):
        now = first + round(1e-3 * ms * _RATE)
        if now - second >= SHORTEST * _RATE:
            measured[row] = squeeze_features(
                times, positions, every, cells, second / _RATE, now / _RATE
            )
            recent = slice(now - round(_window(now - second, LONGEST * _RATE)), now)
            compression = max(float(sensors.compression[recent].mean()), LEAST_TRAVEL)
            exact[row] = np.log(max(float(sensors.force[recent].mean()), 0.1) / compression)
    return measured, exact


def _window(squeezed: float, longest: float) -> float:
    """Return the time over which a squeeze is averaged, in the unit of its duration."""
    return min(SHARE * squeezed, longest)


FEATURES = ("largest travel", "travel", "force")


def squeeze_features(
    times: Values, positions: Values, every: Values, cells: Values, second: float, now: float
) -> Values:
    """Return the logarithms of largest travel, travel and force since the second contact.

    ``positions`` are those of the drives at ``times``, and ``cells`` the sum of all force cells,
    less its value at rest, at the times ``every``.
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
    """Calibration of the stiffness of a squeeze on blocks: a line in logarithms, and a square."""

    middle: Values
    scale: Values
    weights: Values
    #: RMSE on blocks of held-out sessions, Shore A.
    error: float

    @classmethod
    def fit(cls, features: Values, shore_a: Values, sessions: NDArray[np.str_]) -> Self:
        made = cls._fit(features, shore_a)
        errors = []
        for session in np.unique(sessions):
            is_out = sessions == session
            held_out = cls._fit(features[~is_out], shore_a[~is_out]).predict(features[is_out])
            errors.append(held_out - shore_a[is_out])
        return replace(made, error=float(np.sqrt(np.mean(np.concatenate(errors) ** 2))))

    @classmethod
    def _fit(cls, features: Values, shore_a: Values) -> Self:
        middle, scale = features.mean(axis=0), features.std(axis=0) + 1e-9
        made = cls(middle, scale, np.zeros(0), np.nan)
        inputs = made._inputs(features)
        penalty = RIDGE * np.eye(inputs.shape[1])
        penalty[0, 0] = 0.0
        weights = np.linalg.solve(inputs.T @ inputs + penalty, inputs.T @ shore_a)
        return replace(made, weights=np.asarray(weights, np.float64))

    def predict(self, features: Values) -> Values:
        return np.clip(self._inputs(features) @ self.weights, *SHORE_A)

    def _inputs(self, features: Values) -> Values:
        z = (features - self.middle) / self.scale
        return np.column_stack([np.ones(len(z)), z, z[:, 0] ** 2])


class GraspLaw(Record, frozen=True, kw_only=True):
    """Measured errors of the estimates of both fingers and of the squeeze, which weigh them.

    Weights do not depend on the predicted spreads of a pinch: a small spread is often wrong on
    objects unlike blocks. Intervals do. The error of the squeeze has a part that comes from the
    object's structure and not from its hardness.
    """

    #: Bias of the second finger's estimate per second between the contacts, and the time between
    #: the contacts without bias, s.
    drift: float
    usual_gap: float
    #: RMSE of the first and of the second finger, Shore A, and factors on their spreads.
    errors: tuple[float, float]
    scales: tuple[float, float]
    #: Error of the squeeze that comes from the object's structure, Shore A: mean and deviation.
    softer: float
    structure: float
    #: Correlations of the errors of first and second finger, first and squeeze, second and squeeze.
    correlations: tuple[float, float, float]
    #: Half width of the interval as a multiple of the spread, with two and three estimates.
    factors: tuple[float, float] = (NORMAL, NORMAL)

    def corrected(self, values: Values, gaps: Values) -> Values:
        """Return estimates, shape (n, 3), without the bias of second finger and squeeze."""
        bias = np.zeros_like(values)
        bias[:, 1], bias[:, 2] = self.drift * (gaps - self.usual_gap), self.softer
        return np.clip(values - bias, *SHORE_A)

    def combine(self, values: Values, spreads: Values) -> tuple[Values, Values]:
        """Average estimates, shape (n, 3) in the order of ``scales``; NaN stands for a missing one.

        Return the averages and their standard deviations, (n,) each.
        """
        there = np.isfinite(values)
        squeeze = np.hypot(spreads[:, 2], self.structure)
        usual = np.column_stack([*np.broadcast_arrays(*self.errors, squeeze)])
        predicted = np.column_stack([spreads[:, :2] * np.array(self.scales), squeeze])
        weights = np.linalg.solve(self._covariance(usual, there), np.ones((len(values), 3, 1)))
        weights = np.where(there, np.maximum(weights[..., 0], 0.0), 0.0)
        weights /= weights.sum(axis=1, keepdims=True)
        covariance = self._covariance(predicted, there)
        variance = np.einsum("ni,nij,nj->n", weights, covariance, weights)
        return (weights * np.where(there, values, 0.0)).sum(axis=1), np.sqrt(variance)

    def _covariance(self, sd: Values, there: NDArray[np.bool_]) -> Values:
        """Return the covariance of the errors, (n, 3, 3). Missing estimates correlate with none."""
        both, first, second = self.correlations
        shared = np.array([[1.0, both, first], [both, 1.0, second], [first, second, 1.0]])
        sd = np.where(there, sd, 1.0)
        is_pair = (there[:, :, None] & there[:, None, :]) | np.eye(3, dtype=bool)
        return np.asarray(shared * is_pair * sd[:, :, None] * sd[:, None, :])

    def sharpen(
        self, values: Values, spreads: Values, gaps: Values, first: tuple[Values, Values, Values]
    ) -> tuple[Values, Values, Values]:
        """Return averages with the ends of their intervals, (n,) each.

        ``first`` holds the estimates from the first finger, which remain where they are alone.
        """
        value, sd = self.combine(self.corrected(values, gaps), spreads)
        used = np.isfinite(values)
        half = sd * np.where(used[:, 2], self.factors[1], self.factors[0])
        ends = (np.clip(value + sign * half, *SHORE_A) for sign in (-1, 1))
        is_alone = ~used[:, 1:].any(axis=1)
        low, high = ends
        value, low, high = (
            np.where(is_alone, alone, averaged)
            for alone, averaged in zip(first, (value, low, high), strict=True)
        )
        return value, low, high

    @classmethod
    def measure(cls, values: Values, spreads: Values, gaps: Values, truth: Values) -> Self:
        """Measure the law on pinches of known Shore A: estimates and spreads of shape (n, 3)."""
        rows = np.isfinite(values).all(axis=1)
        values, spreads, gaps, truth = values[rows], spreads[rows], gaps[rows], truth[rows]
        errors = values - truth[:, None]
        late = gaps - gaps.mean()
        drift = float(late @ errors[:, 1] / (late @ late))
        errors[:, 1] -= drift * late
        softer = float(errors[:, 2].mean())
        errors[:, 2] -= softer
        first, second, squeeze = np.sqrt(np.mean(errors**2, axis=0)).tolist()
        scales = np.sqrt(np.mean((errors[:, :2] / spreads[:, :2]) ** 2, axis=0)).tolist()
        shared = np.mean(errors[:, :, None] * errors[:, None, :], axis=0)
        sd = np.sqrt(np.diag(shared))
        shared /= sd[:, None] * sd
        on_blocks = float(np.mean(spreads[:, 2] ** 2))
        law = cls(
            drift=drift,
            usual_gap=float(gaps.mean()),
            errors=(first, second),
            scales=(scales[0], scales[1]),
            softer=softer,
            structure=float(np.sqrt(max(squeeze**2 - on_blocks, 0.0))),
            correlations=(float(shared[0, 1]), float(shared[0, 2]), float(shared[1, 2])),
        )
        values = law.corrected(values, gaps)
        factors = []
        for used in (2, 3):
            kept = np.where(np.arange(3) < used, values, np.nan)
            value, sd = law.combine(kept, spreads)
            factors.append(float(np.quantile(np.abs(value - truth) / sd, LEVEL)))
        return structs.replace(law, factors=(factors[0], factors[1]))
