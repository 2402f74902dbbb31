"""Search for the best settings in the payload task, on pinches that are not in the report."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np

from firstcontact.core import Runner
from firstcontact.grasp import Policy
from firstcontact_lab.grasping._trials import PinchSetup, Row, Trial, run_trial
from firstcontact_lab.grasping._variants import Variant, unmodulated, variants
from firstcontact_lab.grasping.results import Tuning
from firstcontact_lab.grasping.settings import HEADLINE, KINDS, SOFT, GraspStudySettings

#: Number of finalists of the first round, which are compared on more pinches.
FINALISTS = 12
#: Largest additional time to a steady grasp, relative to a closing without modulation.
SLOWER = 0.10
#: Objects of the first round: a soft object, and the heaviest object.
FIRST_ROUND = ("block 10", "orange 1")


@dataclass(frozen=True, slots=True)
class _Try:
    variant: Variant
    settings: dict[str, float]
    setups: tuple[PinchSetup, ...]


def search(settings: GraspStudySettings, runner: Runner) -> dict[str, Tuning]:
    """Choose the settings of every variant that has settings to tune."""
    everything = tuple(k for k in settings.kinds if KINDS[k].fragility is None)
    numbers = range(settings.tuning)
    wide = tuple(PinchSetup(k, s, "search", settings.seed) for k in everything for s in numbers)
    short = tuple(PinchSetup(k, s, "search", settings.seed) for k in FIRST_ROUND for s in range(2))
    tuned = {key: v for key, v in variants().items() if v.policy.tunables}
    free = unmodulated()
    limits = {
        setups: _summary(rows)[1] * (1 + SLOWER)
        for setups, rows in zip(
            (short, wide),
            runner.map(_run, [_Try(free, {}, setups) for setups in (short, wide)]),
            strict=True,
        )
    }
    tunings = {}
    rounds = {key: _candidates(v.policy, settings.coarse) for key, v in tuned.items()}
    counts = {key: len(tried) for key, tried in rounds.items()}
    for setups in (short, wide):
        jobs = [_Try(tuned[k], c, setups) for k, tried in rounds.items() for c in tried]
        outcomes = iter(runner.map(_run, jobs))
        for key, tried in rounds.items():
            scored = [(_worth(_summary(next(outcomes)), limits[setups]), c) for c in tried]
            scored.sort(key=lambda pair: pair[0])
            rounds[key] = [c for _, c in scored[:FINALISTS]]
            (_, peak, time, unsteady), best = scored[0]
            tunings[key] = Tuning(
                settings=best, tried=counts[key], peak=peak, time=time, unsteady=unsteady
            )
    return tunings


def _candidates(policy: type[Policy], coarse: bool) -> list[dict[str, float]]:
    """Return every combination of the values of all settings."""
    values = (t.few if coarse else t.tried for t in policy.tunables.values())
    return [dict(zip(policy.tunables, chosen, strict=True)) for chosen in product(*values)]


def _run(one: _Try) -> list[Row]:
    rows = []
    for setup in one.setups:
        trial = Trial(setup, (one.variant,), (HEADLINE,), {one.variant.key: one.settings})
        rows += run_trial(trial)
    return rows


def _summary(rows: list[Row]) -> tuple[float, float, float]:
    """Return mean peak force on soft objects, N, mean time, s, and share of unsteady grasps."""
    soft = [r.peak for r in rows if r.shore_a <= SOFT]
    times = [r.time for r in rows if r.time is not None]
    unsteady = sum(r.time is None or r.dropped for r in rows) / len(rows)
    return float(np.mean(soft)), float(np.mean(times)) if times else 1.0, unsteady


def _worth(summary: tuple[float, float, float], limit: float) -> tuple[float, float, float, float]:
    """Return a sort key: excess over the limits, peak force, time, share of unsteady grasps."""
    peak, time, unsteady = summary
    return (unsteady + max(time / limit - 1, 0.0), peak, time, unsteady)
