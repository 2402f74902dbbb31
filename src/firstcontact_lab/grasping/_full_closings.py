"""Outcomes of tuned policies in full closings, and the gain from stiffness in these closings.

A full closing simulates everything, including the live pipeline and the grasp loop. It does not use
the table of closings.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Runner
from firstcontact.grasp import POLICIES, Policy
from firstcontact_lab.grasping._front import TUNED
from firstcontact_lab.grasping._household_numbers import Judged, baseline, between, candidate
from firstcontact_lab.grasping._judgement import FULL, Judgement
from firstcontact_lab.grasping._own_hand import OwnHand
from firstcontact_lab.grasping._real import RealJob, RealRow, real
from firstcontact_lab.grasping._table import Table
from firstcontact_lab.grasping.results import Between, RealClosings


@dataclass(frozen=True, slots=True)
class FullClosings:
    """Outcomes of full closings by policy, and the gain in successes from stiffness."""

    by_policy: Mapping[str, RealClosings]
    gain: Between


def full_closings(
    judgement: Judgement,
    table: Table,
    weights: NDArray[np.float64],
    hands: Mapping[tuple[int, float], OwnHand],
    runner: Runner,
) -> FullClosings:
    """Simulate full closings of every pick for judging, with four policies."""
    kinds: list[type[Policy]] = [baseline(), candidate(), baseline(True), candidate(True)]
    chosen, everyone = judgement.chosen(), judgement.everyone
    jobs = [
        RealJob(p, k.name, chosen[k.name](p.kind), *(FULL if k.has_reflex() else ("abrupt", None)))
        for k in kinds
        for p in table.picks
    ]
    rows = runner.map(real, jobs, hands)
    by_policy = {
        k.name: _shares([r for r in rows if r.job.policy == k.name], everyone[k.name], weights)
        for k in kinds
    }
    return FullClosings(by_policy, _gain(rows, weights))


def _gain(rows: Sequence[RealRow], weights: NDArray[np.float64]) -> Between:
    """Return the share of successes with stiffness minus the share without, on the same picks."""
    fine = [
        np.array([not (r.dropped or r.damaged) for r in rows if r.job.policy == kind.name], float)
        for kind in (candidate(), baseline())
    ]
    apart = fine[0] - fine[1]
    return between(float(apart.mean()), apart @ weights / weights.sum(axis=0))


def _shares(
    rows: Sequence[RealRow], judgement: Judged, weights: NDArray[np.float64]
) -> RealClosings:
    """Return the share of each outcome of a tuned policy. Rows and weights have the same order."""
    dropped = np.array([r.dropped for r in rows])
    damaged = np.array([r.damaged for r in rows])
    # A damaged object that also falls counts as damaged only.
    dropped &= ~damaged
    fine = ~(dropped | damaged)
    outcomes = judgement.outcomes
    alike = fine == (np.maximum(outcomes.dropped[TUNED], outcomes.damaged[TUNED]) < 1)
    deadline = POLICIES[rows[0].job.policy].deadline
    times = [1e3 * r.steady for r in rows if r.steady is not None]

    def share(flags: np.ndarray) -> Between:
        drawn = flags.astype(np.float64) @ weights / weights.sum(axis=0)
        return between(float(flags.mean()), drawn)

    return RealClosings(
        n=len(rows),
        success=float(fine.mean()),
        dropped=float(dropped.mean()),
        damaged=float(damaged.mean()),
        steady=len(times) / len(rows),
        steady_ms=float(np.mean(times)) if times else None,
        as_table=float(alike.mean()),
        in_time=None if deadline is None else float(np.mean([r.estimates > 0 for r in rows])),
        intervals={
            name: (b.low, b.high)
            for name, b in {
                "success": share(fine), "dropped": share(dropped), "damaged": share(damaged)
            }.items()
        },
    )  # fmt: skip
