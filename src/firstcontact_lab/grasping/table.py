"""Table of simulated picks for the grasp study: outcomes by approach speed and grip force."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Command, Estimate
from firstcontact.core.layout import FINGERTIP_RATE
from firstcontact.core.physics import GRAVITY, holding_force
from firstcontact.grasp import Grip
from firstcontact.twin.household import household_named
from firstcontact.twin.outcome import Lift
from firstcontact.twin.plant import GraspPlant
from firstcontact_lab.grasping.hands import AdaptedHands, SlipWatch
from firstcontact_lab.grasping.picks import LIFTS, SLIP_STEP, Pick, pick_specimen, simulate_approach

Values = NDArray[np.float64]
#: Assumed latencies of the slip detection, s.
DETECTION = (0.100, 0.300)
#: Number of samples to simulate at a time when no policy reads them.
LOT = 100


@dataclass(frozen=True, slots=True)
class ClosingGrid:
    """Approach speeds (m/s), grip forces (N) and slip boosts whose combinations are simulated.

    A slip boost is the factor by which a slip reflex raises the grip force.
    """

    speeds: tuple[float, ...]
    forces: tuple[float, ...]
    boosts: tuple[float, ...]


@dataclass(frozen=True, slots=True, eq=False)
class ApproachOutcomes:
    pick: Pick
    speed: float
    mass: float
    friction: float
    limit: float
    estimate: Estimate | None
    answers: tuple[Estimate, ...]
    heard: float | None
    peak: Values
    hold: Values
    slip_peak: Values
    slip_drop: Values


def simulate_approach_outcomes(
    job: tuple[Pick, float], hands: AdaptedHands, how: ClosingGrid
) -> ApproachOutcomes:
    """Simulate one approach to an object, and then a grip and a lift for each grip force.

    ``job`` is (pick, approach speed in m/s).
    """
    pick, speed = job
    specimen = pick_specimen(pick)
    begun = simulate_approach(pick, speed, hands[pick.hand, speed])
    shape = (len(LIFTS), len(DETECTION), len(how.boosts), len(how.forces))
    peak, hold = np.empty((2, len(how.forces)))
    slip_peak, slip_drop = np.full((2, *shape), np.nan)
    for place, force in enumerate(how.forces):
        plant = begun.plant.copy()
        plant.command(Grip().pressing(force))
        _advance_until(plant, Lift().delay)
        lifted = plant.copy()
        _advance_until(lifted, np.inf)
        forces = lifted.forces
        peak[place], hold[place] = forces.max(), forces[-1].sum()
        if specimen.friction * hold[place] >= specimen.mass * GRAVITY:
            continue
        for (a, lift), (b, wait), (c, boost) in product(
            enumerate(LIFTS.values()), enumerate(DETECTION), enumerate(how.boosts)
        ):
            again = plant.copy(lift)
            slip_peak[a, b, c, place], slip_drop[a, b, c, place] = _lift_with_reflex(
                again, force, wait, boost, speed
            )
    limit = np.inf if specimen.fragility is None else specimen.fragility.scale
    return ApproachOutcomes(
        pick, speed, specimen.mass, specimen.friction, limit, begun.estimate, begun.answers,
        begun.heard, peak, hold, slip_peak, slip_drop,
    )  # fmt: skip


def _advance_until(plant: GraspPlant, since: float) -> None:
    """Advance a simulated closing to ``since`` s after the first contact, or to its end."""
    contacts = plant.contacts
    end = contacts[0].sample + since * FINGERTIP_RATE if contacts else np.inf
    while not plant.ended and plant.sample < end:
        plant.move(int(min(LOT, max(end - plant.sample, 1))))


def _lift_with_reflex(
    plant: GraspPlant, force: float, wait: float, boost: float, speed: float
) -> tuple[float, bool]:
    """Lift an object with a slip reflex. Return (largest contact force in N, True if dropped).

    At each slip, the reflex multiplies the grip force ``force``, N, by ``boost``. It detects a slip
    after ``wait`` s. After a slip, the hand closes with at least ``speed`` m/s.
    """
    watch = SlipWatch(wait)
    while not plant.ended and not plant.lost:
        plant.move(SLIP_STEP)
        if watch.slips(plant):
            force = min(force * boost, Grip().force)
            pressing = Grip().pressing(force)
            plant.command(Command(max(pressing.speed, speed), pressing.force))
    return float(plant.forces.max()), plant.lost or plant.outcome.dropped


@dataclass(frozen=True, slots=True, eq=False)
class ReflexIndices:
    """Indices of a slip reflex in a :class:`ClosingTable`: type of lift, latency, and boost."""

    lift: int
    detection: int
    boost: int


@dataclass(frozen=True, slots=True, eq=False)
class Outcomes:
    dropped: Values
    damaged: Values


@dataclass(frozen=True, slots=True, eq=False)
class ClosingTable:
    """Simulated forces and estimates of each pick, at all approach speeds and grip forces."""

    how: ClosingGrid
    picks: tuple[Pick, ...]
    needed: Values
    limit: Values
    estimates: tuple[tuple[Estimate | None, ...], ...]
    peak: Values
    hold: Values
    slip_peak: Values
    slip_drop: Values

    @classmethod
    def from_branches(cls, rows: Sequence[ApproachOutcomes], how: ClosingGrid) -> ClosingTable:
        """Return the table from one simulation per pick and approach speed, in any order."""
        by = {(row.speed, row.pick): row for row in rows}
        picks = tuple(sorted({row.pick for row in rows}))
        first = [by[how.speeds[0], pick] for pick in picks]
        stacked = {
            name: np.array([[getattr(by[v, p], name) for p in picks] for v in how.speeds])
            for name in ("peak", "hold", "slip_peak", "slip_drop")
        }
        return cls(
            how,
            picks,
            needed=np.array([2 * holding_force(row.mass, row.friction) for row in first]),
            limit=np.array([row.limit for row in first]),
            estimates=tuple(tuple(by[v, p].estimate for p in picks) for v in how.speeds),
            **stacked,
        )

    @property
    def kinds(self) -> NDArray[np.str_]:
        return np.array([pick.kind for pick in self.picks])

    @property
    def hands(self) -> NDArray[np.intp]:
        return np.array([pick.hand for pick in self.picks], np.intp)

    @property
    def shore_a(self) -> Values:
        return np.array([household_named(p.kind).numbers.shore_a.value for p in self.picks])

    def with_properties(
        self, needed: Values | None = None, limit: Values | None = None
    ) -> ClosingTable:
        return replace(
            self,
            needed=self.needed if needed is None else needed,
            limit=self.limit if limit is None else limit,
        )

    def interpolate_forces(self, speed: int, forces: Values) -> tuple[Values, Values]:
        """Return the largest contact force of each pick, and the final force of both fingers, N.

        ``speed`` is the index of an approach speed, and ``forces`` are the grip forces of the
        picks, N. Results are interpolated between the simulated grip forces.
        """
        place, part = self._places(forces)
        rows = np.arange(len(self.picks))

        def between(values: Values) -> Values:
            low, high = values[rows, place], values[rows, place + 1]
            return low + part * (high - low)

        return between(self.peak[speed]), between(self.hold[speed])

    def judge(self, peak: Values, hold: Values, scatter: float = 0.0) -> Outcomes:
        return Outcomes(
            exceedance_probability(self.needed, hold, scatter),
            exceedance_probability(peak, self.limit, scatter),
        )

    def _places(self, forces: Values) -> tuple[NDArray[np.intp], Values]:
        grid = np.array(self.how.forces)
        within = np.clip(forces, grid[0], grid[-1])
        place = np.clip(np.searchsorted(grid, within) - 1, 0, len(grid) - 2)
        return place, (within - grid[place]) / (grid[place + 1] - grid[place])

    def outcomes(
        self, speed: int, forces: Values, reflex: ReflexIndices | None = None, scatter: float = 0.0
    ) -> Outcomes:
        peak, hold = self.interpolate_forces(speed, forces)
        plain = self.judge(peak, hold, scatter)
        if reflex is None:
            return plain
        # Use the nearest force of the table at which the object slips.
        place, part = self._places(forces)
        rows = np.arange(len(self.picks))
        at = (speed, slice(None), reflex.lift, reflex.detection, reflex.boost)
        drops, peaks = self.slip_drop[at], self.slip_peak[at]
        near = place + (part > 0.5)
        near = np.where(np.isnan(drops[rows, near]), place, near)
        slips = ~np.isnan(drops[rows, near])
        saved = slips & (drops[rows, near] < 0.5)
        harder = exceedance_probability(
            np.where(slips, peaks[rows, near], 0.0), self.limit, scatter
        )
        # The reflex presses only objects that slip harder.
        damaged = np.maximum(plain.damaged, harder * plain.dropped)
        return Outcomes(np.where(saved, 0.0, plain.dropped), damaged)


def exceedance_probability(one: Values, other: Values, scatter: float) -> Values:
    """Return the probability that force ``one`` is larger than force ``other``.

    ``scatter`` is the relative standard deviation of their random variation.
    """
    if scatter <= 0:
        return (one > other).astype(np.float64)
    with np.errstate(divide="ignore"):
        away = (np.log(one) - np.log(other)) / scatter
    # Logistic function, which is within a hundredth of the normal distribution function.
    share: Values = 1 / (1 + np.exp(-1.702 * np.clip(away, -30, 30)))
    return share
