"""Run of the grasp study: simulate hands, tune and judge policies, and write the report."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np
from msgspec import structs
from numpy.typing import NDArray

from firstcontact.grasp import POLICIES
from firstcontact.grasp.household_policies import APPROACH, BOOST
from firstcontact.jobs import Runner
from firstcontact.twin.household import HOUSEHOLD as OBJECTS
from firstcontact.twin.household import household_named
from firstcontact_lab.grasping.hands import AdaptedHands, adapt_to_hand
from firstcontact_lab.grasping.judgement import (
    FULL,
    JudgedPolicy,
    PolicyJudgements,
    Tables,
    baseline,
    best_possible_front,
    candidate,
    drop_reduction,
    drop_reduction_at_fixed_scale,
    drop_share,
    judge_policies,
    reduction_after_swaps,
    reductions_by_assumption,
    resample_weights,
    with_interval,
)
from firstcontact_lab.grasping.page import (
    GRASP_PARTS,
    HOUSEHOLD,
    fronts_figure,
    fronts_picture,
    grasp_page,
)
from firstcontact_lab.grasping.picks import (
    FullPickJob,
    FullPickOutcome,
    Pick,
    simulate_full_closing,
)
from firstcontact_lab.grasping.results import (
    CEILING,
    FIRMEST,
    USED,
    Between,
    ChosenSettings,
    Estimates,
    FrontPoints,
    FullClosingShares,
    Household,
    ObjectErrors,
    PickSummary,
    Reflexes,
    ReflexSuccess,
)
from firstcontact_lab.grasping.table import (
    ApproachOutcomes,
    ClosingGrid,
    ClosingTable,
    Values,
    simulate_approach_outcomes,
)
from firstcontact_lab.grasping.tuning import DAMAGE, FAMILIES, TUNED, Front, assign_folds, family_of
from firstcontact_lab.report.findings import PartResult
from firstcontact_lab.report.page import State
from firstcontact_lab.report.run import Job, run_steps

TARGET = 0.35
WINDOWS = (0.003, 0.005, 0.008, 0.015)
#: Tolerance for the length of a window, s, because windows have whole numbers of samples.
HALF = 1e-4


@dataclass(frozen=True, slots=True)
class GraspStudySettings:
    tuning_hands: int = 3
    judged_hands: int = 4
    tuning_specimens: tuple[int, ...] = (1,)
    judged_specimens: tuple[int, ...] = (2, 3)
    blocks: int = 10
    speeds: tuple[float, ...] = APPROACH.tried
    boosts: tuple[float, ...] = BOOST.tried
    forces: tuple[float, ...] = (1.0, 1.41, 2.0, 2.83, 4.0, 5.66, 8.0, 12.0)
    folds: int = 6
    budget: int = 512
    few: bool = False
    permutations: int = 40
    kinds: tuple[str, ...] = tuple(item.name for item in OBJECTS)
    seed: int = 0
    workers: int = 2

    def hand_seeds(self) -> tuple[list[int], list[int]]:
        """Return two lists of seeds: hands for tuning, and hands for judging."""
        first = 1000 * (self.seed + 1)
        tuning = [first + 100 + n for n in range(self.tuning_hands)]
        return tuning, [first + 200 + n for n in range(self.judged_hands)]

    def quick(self) -> GraspStudySettings:
        """Return settings of a quick trial, which runs all code. Do not quote its numbers."""
        return replace(
            self,
            tuning_hands=1,
            judged_hands=2,
            judged_specimens=(2,),
            blocks=6,
            speeds=APPROACH.few,
            boosts=BOOST.few,
            forces=(1.0, 2.0, 4.0, 8.0, 12.0),
            folds=3,
            budget=32,
            few=True,
            permutations=4,
            kinds=self.kinds[::4],
        )


class HouseholdStudy:
    hands: AdaptedHands
    tuning: list[ApproachOutcomes]
    rows: list[ApproachOutcomes]
    tables: Tables
    weights: Values
    judgement: PolicyJudgements
    full: list[FullPickOutcome]

    def __init__(self, settings: GraspStudySettings, runner: Runner) -> None:
        self.settings, self._runner = settings, runner
        self._how = ClosingGrid(settings.speeds, settings.forces, settings.boosts)
        self.tuning_hands, self.judged_hands = settings.hand_seeds()

    def adapt_hands(self) -> None:
        seeds = (*self.tuning_hands, *self.judged_hands)
        hands = [(h, v) for h in seeds for v in self._how.speeds]
        made = self._runner.map(adapt_to_hand, hands, self.settings.blocks)
        self.hands = dict(zip(hands, made, strict=True))

    def simulate_tuning(self) -> None:
        self.tuning = self._closings(self.tuning_hands, self.settings.tuning_specimens)

    def simulate_judged(self) -> None:
        self.rows = self._closings(self.judged_hands, self.settings.judged_specimens)

    def _closings(self, seeds: Sequence[int], specimens: Sequence[int]) -> list[ApproachOutcomes]:
        picks = [Pick(k, h, s) for k in self.settings.kinds for h in seeds for s in specimens]
        jobs = [(p, v) for p in picks for v in self._how.speeds]
        return self._runner.map(simulate_approach_outcomes, jobs, self.hands, self._how)

    def tune(self) -> None:
        settings = self.settings
        self.tables = Tables(
            ClosingTable.from_branches(self.tuning, self._how),
            ClosingTable.from_branches(self.rows, self._how),
            settings.folds,
            settings.budget,
            settings.few,
            settings.seed,
        )
        self.weights = resample_weights(self.tables.judged, settings.seed)
        self.judgement = judge_policies(self.tables)

    def close(self) -> None:
        """Simulate the whole closing of each judged pick, to check the interpolated results."""
        chosen = self.judgement.chosen()
        jobs = [
            FullPickJob(
                pick, kind.name, chosen[kind.name](pick.kind),
                *(FULL if kind.has_reflex() else ("abrupt", None)),
            )
            for kind in (baseline(), candidate(), baseline(True), candidate(True))
            for pick in self.tables.judged.picks
        ]  # fmt: skip
        self.full = self._runner.map(simulate_full_closing, jobs, self.hands)

    def results(self) -> Household:
        tables, table, weights = self.tables, self.tables.judged, self.weights
        judged, seed = self.judgement, self.tables.seed
        blind, ours, everyone = judged.blind, judged.ours, judged.everyone
        best = best_possible_front(table)
        between_of = {name: drop_share(policy, weights) for name, policy in everyone.items()}
        full = dict.fromkeys(row.job.policy for row in self.full)
        closings = {name: self._shares(name, everyone[name]) for name in full}
        successes = {name: _success(policy) for name, policy in everyone.items()}
        count = self.settings.permutations
        return Household(
            objects=len(set(table.kinds)),
            hands=len(set(table.hands.tolist())),
            picks=len(table.picks),
            damage=DAMAGE,
            success={
                **successes,
                **{name: policy.success for name, policy in closings.items()},
                CEILING: 1 - float((best.dropped + best.damaged).min()),
            },
            drops_at_10_damage={
                **{name: policy.value for name, policy in between_of.items()},
                CEILING: float(best.drop_share()),
            },
            drops_between=between_of,
            fewer_drops_than_blind=drop_reduction(ours, blind, weights),
            fewer_drops_as_bold=drop_reduction_at_fixed_scale(ours, blind, weights),
            success_gain=self._success_gain(),
            fewer={
                n: drop_reduction(f, blind, weights)
                for n, f in judged.plain.items()
                if f is not blind
            },
            target=TARGET,
            controls={
                "mass_permuted": reduction_after_swaps(tables, count, True, False, seed),
                "damage_permuted": reduction_after_swaps(tables, count, False, True, seed),
                "both_permuted": reduction_after_swaps(tables, count, True, True, seed),
            },
            slip_reflex={n: _reflexes(b, s, weights) for n, (b, s) in judged.reflexes.items()},
            sensitivity=reductions_by_assumption(tables),
            fronts={
                **{name: _points(policy.front) for name, policy in everyone.items()},
                CEILING: _points(best),
            },
            closings=closings,
            estimates=self._estimates(),
            by_object=self._by_object(),
            tuned={name: _chosen(policy, judged.fold_of) for name, policy in everyone.items()},
            tuned_on=self._picks_of(tables.tuning),
            judged_on=self._picks_of(table),
        )

    def _picks_of(self, table: ClosingTable) -> PickSummary:
        return PickSummary(
            hands=sorted(set(table.hands.tolist())),
            specimens=sorted({pick.specimen for pick in table.picks}),
            picks=len(table.picks),
            budget=self.tables.budget,
            folds=self.tables.folds,
            families=[list(words) for words in FAMILIES],
        )

    def _success_gain(self) -> Between:
        """Return the rise in the share of successful picks if the policy uses stiffness.

        A policy with and a policy without stiffness pick the same objects with the same hands.
        """
        ours, blind = (
            np.array([not (r.dropped or r.damaged) for r in self.full if r.job.policy == k.name])
            for k in (candidate(), baseline())
        )
        return self._mean_with_interval(ours.astype(float) - blind.astype(float))

    def _mean_with_interval(self, flags: Values | NDArray[np.bool_]) -> Between:
        """Return the mean of ``flags`` (one per judged pick) with a bootstrap interval."""
        drawn = flags.astype(np.float64) @ self.weights / self.weights.sum(axis=0)
        return with_interval(float(flags.mean()), drawn)

    def _shares(self, name: str, judged: JudgedPolicy) -> FullClosingShares:
        rows = [row for row in self.full if row.job.policy == name]
        damaged = np.array([r.damaged for r in rows])
        # A damaged object that also falls counts as damaged only.
        dropped = np.array([r.dropped for r in rows]) & ~damaged
        fine = ~(dropped | damaged)
        outcomes = judged.outcomes
        alike = fine == (np.maximum(outcomes.dropped[TUNED], outcomes.damaged[TUNED]) < 1)
        deadline = POLICIES[name].deadline
        times = [1e3 * r.steady for r in rows if r.steady is not None]
        shares = {
            "success": self._mean_with_interval(fine),
            "dropped": self._mean_with_interval(dropped),
            "damaged": self._mean_with_interval(damaged),
        }
        return FullClosingShares(
            n=len(rows),
            **{outcome: share.value for outcome, share in shares.items()},
            steady=len(times) / len(rows),
            steady_ms=float(np.mean(times)) if times else None,
            as_table=float(alike.mean()),
            in_time=None if deadline is None else float(np.mean([r.estimates > 0 for r in rows])),
            intervals={outcome: (share.low, share.high) for outcome, share in shares.items()},
        )

    def _approaches(self) -> list[ApproachOutcomes]:
        """Return the simulation of each judged pick at the approach speed tuned for its object."""
        judged = self.judgement
        speeds = [chosen.settings["approach"] for chosen in judged.ours.chosen]
        fold_of = assign_folds(sorted(set(self.tables.judged.kinds)), self.tables.folds)
        return [row for row in self.rows if row.speed == speeds[fold_of[row.pick.kind]]]

    def _estimates(self) -> Estimates:
        rows = self._approaches()
        within = [r for r in rows if _label(r) <= FIRMEST]
        longest = [max((a.elapsed for a in r.answers), default=0.0) for r in rows]
        hands = sorted({(r.pick.hand, r.speed) for r in rows})
        return Estimates(
            rmse=_rmse(_errors_by_window(rows)),
            bearing=_rmse(_errors_by_window(within)),
            decided={f"{1e3 * w:g}": float(np.mean([d >= w - 5e-4 for d in longest]))
                     for w in WINDOWS},
            block_rmse=float(np.sqrt(np.mean([self.hands[h].rmse ** 2 for h in hands]))),
            unanswered=float(np.mean([r.estimate is None for r in rows])),
            heard=float(np.mean([r.heard is not None for r in rows])),
        )  # fmt: skip

    def _by_object(self) -> dict[str, ObjectErrors]:
        """Return the errors of estimates, drops and damage of each object, by the object's name."""
        policies = {baseline().name: self.judgement.blind, candidate().name: self.judgement.ours}
        by_kind: dict[str, list[ApproachOutcomes]] = {}
        for row in self._approaches():
            by_kind.setdefault(row.pick.kind, []).append(row)
        out = {}
        for kind, rows in by_kind.items():
            errors = _errors_by_window(rows)
            of_kind = self.tables.judged.kinds == kind
            numbers = household_named(kind).numbers
            outcomes = {name: policy.outcomes for name, policy in policies.items()}
            out[kind] = ObjectErrors(
                shore_a=numbers.shore_a.value,
                family=family_of(kind),
                fragile=numbers.limit is not None,
                n=len(rows),
                answered=len(errors[USED]),
                rmse=_rmse(errors),
                bias=float(np.mean(errors[USED])) if errors[USED] else None,
                drops={n: float(o.dropped[TUNED, of_kind].mean()) for n, o in outcomes.items()},
                damage={n: float(o.damaged[TUNED, of_kind].mean()) for n, o in outcomes.items()},
            )
        return out


def _label(row: ApproachOutcomes) -> float:
    return household_named(row.pick.kind).numbers.shore_a.value


def _errors_by_window(rows: Sequence[ApproachOutcomes]) -> dict[str, list[float]]:
    """Return the errors of estimates, Shore A, by window length in ms.

    The key ``USED`` has the errors of the estimates that policies used.
    """
    errors: dict[str, list[float]] = {f"{1e3 * w:g}": [] for w in WINDOWS}
    errors[USED] = []
    for row in rows:
        label = _label(row)
        for window in WINDOWS:
            complete = [a for a in row.answers if abs(a.elapsed - window) < 5e-4 + HALF]
            if complete:
                nearest = min(complete, key=lambda a: abs(a.elapsed - window))
                errors[f"{1e3 * window:g}"].append(nearest.value - label)
        if row.estimate is not None:
            errors[USED].append(row.estimate.value - label)
    return errors


def _rmse(errors: Mapping[str, Sequence[float]]) -> dict[str, float]:
    return {w: float(np.sqrt(np.mean(np.square(e)))) for w, e in errors.items() if len(e)}


def _success(judged: JudgedPolicy) -> float:
    outcomes = judged.outcomes
    return float(1 - np.maximum(outcomes.dropped[TUNED], outcomes.damaged[TUNED]).mean())


def _points(front: Front) -> FrontPoints:
    return FrontPoints(dropped=front.dropped.tolist(), damaged=front.damaged.tolist())


def _reflexes(blind: JudgedPolicy, ours: JudgedPolicy, weights: Values) -> Reflexes:
    return Reflexes(
        blind=drop_share(blind, weights),
        stiffness=drop_share(ours, weights),
        fewer=drop_reduction(ours, blind, weights),
        success=ReflexSuccess(blind=_success(blind), stiffness=_success(ours)),
    )


def _chosen(judged: JudgedPolicy, fold_of: Mapping[str, int]) -> list[ChosenSettings]:
    return [
        structs.replace(one, left_out=[kind for kind, of in fold_of.items() if of == fold])
        for fold, one in enumerate(judged.chosen)
    ]


def run_grasp_study(settings: GraspStudySettings, out: Path, quick: bool) -> Path:
    """Run a grasp study in the folder ``out``. Return the path of the report."""
    sizes = asdict(settings)
    state = State(
        settings=sizes,
        options={"verb": "grasp-study", **{k: v for k, v in sizes.items() if k != "workers"}},
        parts=GRASP_PARTS,
        page=grasp_page,
        quick=quick,
    )
    return run_steps(out, state, settings.workers, lambda runner: _jobs(settings, out, runner))


def _jobs(settings: GraspStudySettings, out: Path, runner: Runner) -> list[Job]:
    household = HouseholdStudy(settings, runner)

    def judge() -> PartResult:
        results = household.results()
        fronts_picture(results, out / "grasp.png")
        return PartResult([HOUSEHOLD(results)], [fronts_figure(results)])

    def job(title: str, run: Callable[[], PartResult | None], cost: float) -> Job:
        return Job("twin", "household", title, lambda: run() or PartResult(), vital=True, cost=cost)

    return [
        job("own hands", household.adapt_hands, 20),
        job("closings to tune on", household.simulate_tuning, 25),
        job("closings to judge", household.simulate_judged, 60),
        job("tuning", household.tune, 15),
        job("full closings", household.close, 20),
        job("controls", judge, 30),
    ]
