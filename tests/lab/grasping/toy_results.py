"""Artificial results of a grasp study."""

from __future__ import annotations

from firstcontact_lab.grasping._household_numbers import conditions, household_policies
from firstcontact_lab.grasping._numbers import by_policy
from firstcontact_lab.grasping.results import (
    Between,
    ChosenSettings,
    Estimates,
    Filmed,
    FrontPoints,
    GraspData,
    GraspResults,
    GraspRun,
    Household,
    ModelErrors,
    ObjectErrors,
    Payload,
    RealClosings,
    Reflexes,
    ReflexSuccess,
    TunedOn,
    Tuning,
)

GAIN = Between(value=0.5, low=0.1, high=0.9)
POLICIES = household_policies()


def household() -> Household:
    """Return results in which every policy drops a fifth of the picks."""
    shares = dict.fromkeys(POLICIES, 0.2)
    on = TunedOn(hands=[1100, 1101], specimens=[1], picks=9, budget=8, folds=2, families=[["egg"]])
    return Household(
        objects=9, hands=2, picks=18, damage=0.1,
        success=shares | {"ceiling": 1.0},
        drops_at_10_damage=shares | {"ceiling": 0.0},
        drops_between=dict.fromkeys(POLICIES, Between(value=0.2, low=0.1, high=0.3)),
        fewer_drops_than_blind=GAIN, fewer_drops_as_bold=GAIN, success_gain=GAIN,
        fewer={"stiffness": GAIN}, target=0.35,
        controls=dict.fromkeys(("mass_permuted", "damage_permuted", "both_permuted"), GAIN),
        slip_reflex=dict.fromkeys(
            conditions(),
            Reflexes(
                blind=Between(value=0.2, low=0.1, high=0.3),
                stiffness=Between(value=0.1, low=0.0, high=0.2),
                fewer=GAIN, success=ReflexSuccess(blind=0.7, stiffness=0.8),
            ),
        ),
        sensitivity={"estimated limits × 0.7": GAIN},
        fronts=dict.fromkeys(
            [*POLICIES, "ceiling"],
            FrontPoints(dropped=[0.4, 0.2, 0.1], damaged=[0.0, 0.1, 0.3]),
        ),
        closings={
            "blind": RealClosings(
                n=18, success=0.7, dropped=0.2, damaged=0.1, steady=0.8, steady_ms=150.0,
                as_table=1.0,
                intervals=dict.fromkeys(("success", "dropped", "damaged"), (0.1, 0.9)),
            )
        },
        estimates=Estimates(
            rmse={"5": 9.0, "used": 8.0}, bearing={"5": 5.0}, decided={"5": 0.9},
            block_rmse=3.0, unanswered=0.02, heard=0.98,
        ),
        by_object={
            name: ObjectErrors(
                shore_a=30.0, family=name, fragile=name == "egg", n=2, answered=n,
                rmse={"5": 4.0, "used": 3.0} if n else {}, bias=-2.0 if n else None,
                drops=shares, damage=shares,
            )
            for name, n in (("egg", 2), ("can", 0))
        },
        tuned={
            name: [
                ChosenSettings(
                    left_out=["egg"],
                    settings={key: t.tried[0] for key, t in kind.tunables.items()} | {"scale": 1.1},
                    tried=8, drops=0.2, damage=0.1,
                )
            ]
            for name, kind in POLICIES.items()
        },
        tuned_on=on, judged_on=on,
    )  # fmt: skip


def payload() -> Payload:
    """Return payload results of the made-up rows."""
    from toy_rows import rows

    tuning = Tuning(
        settings={"threshold": 0.05, "approach": 1.5, "speed": 0.02, "force": 2.6},
        tried=7, peak=3.0, time=0.14, unsteady=0.0,
    )  # fmt: skip
    return Payload(
        data=GraspData(
            source="twin",
            objects=["block 5"],
            sessions=4,
            pinches=16,
            closings=96,
            training=100,
            latencies_ms=[20.0],
        ),
        models=ModelErrors(rmse={"15": 3.21}, interval_width={"15": 8.0}),
        feedback={"feedback": tuning},
        policies=by_policy(rows(), 0),
    )


def results(payload_results: Payload | None = None) -> GraspResults:
    """Return the results of a whole study."""
    return GraspResults(
        study=GraspRun(
            command="firstcontact grasp-study <b>", started="now", seconds=12.0, quick=True,
            seed=3, workers=2, versions={"python": "3"},
        ),
        household=household(),
        payload=payload_results or payload(),
        film=Filmed(objects=["raspberry", "hammer"], hand=1200, specimen=2),
    )  # fmt: skip
