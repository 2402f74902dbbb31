"""Table of the outcomes of every grip force for every pick."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Estimate, holding_force
from firstcontact.twin import household_named
from firstcontact_lab.grasping._approach import Pick
from firstcontact_lab.grasping._branches import Branches, Branching

Values = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Reflexed:
    """Slip reflex: table indices of its lift, its latency of slip detection and its boost."""

    lift: int
    detection: int
    boost: int


@dataclass(frozen=True, slots=True, eq=False)
class Outcomes:
    """Outcomes of every pick: dropped or not, damaged or not."""

    dropped: Values
    damaged: Values


@dataclass(frozen=True, slots=True, eq=False)
class Table:
    """Simulated forces and estimates of every pick at every approach speed and grip force."""

    how: Branching
    picks: tuple[Pick, ...]
    needed: Values
    limit: Values
    estimates: tuple[tuple[Estimate | None, ...], ...]
    peak: Values
    hold: Values
    slip_peak: Values
    slip_drop: Values

    @classmethod
    def from_branches(cls, rows: Sequence[Branches], how: Branching) -> Table:
        """Return the table from the outcomes of every pick at every speed. Rows have any order."""
        by = {(row.speed, row.pick): row for row in rows}
        picks = tuple(sorted({row.pick for row in rows}))
        first = [by[how.speeds[0], pick] for pick in picks]

        def stacked(name: str) -> Values:
            return np.array([[getattr(by[v, p], name) for p in picks] for v in how.speeds])

        return cls(
            how,
            picks,
            np.array([2 * holding_force(row.mass, row.friction) for row in first]),
            np.array([row.limit for row in first]),
            tuple(tuple(by[v, p].estimate for p in picks) for v in how.speeds),
            stacked("peak"),
            stacked("hold"),
            stacked("slip_peak"),
            stacked("slip_drop"),
        )

    @property
    def kinds(self) -> NDArray[np.str_]:
        """Name of each pick's object, shape (picks,)."""
        return np.array([pick.kind for pick in self.picks])

    @property
    def hands(self) -> NDArray[np.intp]:
        """Seed of each pick's hand, shape (picks,)."""
        return np.array([pick.hand for pick in self.picks], np.intp)

    @property
    def shore_a(self) -> Values:
        """Label of each pick's object, shape (picks,)."""
        return np.array([household_named(p.kind).numbers.shore_a.value for p in self.picks])

    def otherwise(self, needed: Values | None = None, limit: Values | None = None) -> Table:
        """Return a copy of the table with the given needed forces or limits."""
        return replace(
            self,
            needed=self.needed if needed is None else needed,
            limit=self.limit if limit is None else limit,
        )

    def pressed(self, speed: int, forces: Values) -> tuple[Values, Values]:
        """Return the largest contact force and the sum of both contact forces at the end, N."""
        place, part = self._places(forces)
        rows = np.arange(len(self.picks))

        def between(values: Values) -> Values:
            low, high = values[rows, place], values[rows, place + 1]
            return low + part * (high - low)

        return between(self.peak[speed]), between(self.hold[speed])

    def judge(self, peak: Values, hold: Values, scatter: float = 0.0) -> Outcomes:
        """Return the outcomes without a slip reflex, from the two results of :meth:`pressed`."""
        return Outcomes(exceeds(self.needed, hold, scatter), exceeds(peak, self.limit, scatter))

    def _places(self, forces: Values) -> tuple[NDArray[np.intp], Values]:
        grid = np.array(self.how.forces)
        within = np.clip(forces, grid[0], grid[-1])
        place = np.clip(np.searchsorted(grid, within) - 1, 0, len(grid) - 2)
        return place, (within - grid[place]) / (grid[place + 1] - grid[place])

    def outcomes(
        self, speed: int, forces: Values, reflex: Reflexed | None = None, scatter: float = 0.0
    ) -> Outcomes:
        """Return the outcomes of every pick at the given grip forces."""
        peak, hold = self.pressed(speed, forces)
        plain = self.judge(peak, hold, scatter)
        if reflex is None:
            return plain
        dropped, damaged = plain.dropped, plain.damaged
        # Use the nearest force of the table at which the object slips.
        place, part = self._places(forces)
        rows = np.arange(len(self.picks))
        at = (speed, slice(None), reflex.lift, reflex.detection, reflex.boost)
        drops, peaks = self.slip_drop[at], self.slip_peak[at]
        near = place + (part > 0.5)
        near = np.where(np.isnan(drops[rows, near]), place, near)
        slips = ~np.isnan(drops[rows, near])
        saved = slips & (drops[rows, near] < 0.5)
        harder = exceeds(np.where(slips, peaks[rows, near], 0.0), self.limit, scatter)
        # The reflex presses only objects that slip harder.
        damaged = np.maximum(damaged, harder * dropped)
        return Outcomes(np.where(saved, 0.0, dropped), damaged)


def exceeds(one: Values, other: Values, scatter: float) -> Values:
    """Return the probability that one number exceeds the other."""
    if scatter <= 0:
        return (one > other).astype(np.float64)
    with np.errstate(divide="ignore"):
        away = (np.log(one) - np.log(other)) / scatter
    # Logistic function, which is within a hundredth of the normal distribution function.
    share: Values = 1 / (1 + np.exp(-1.702 * np.clip(away, -30, 30)))
    return share
