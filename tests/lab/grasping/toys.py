"""Artificial picks, rows and results of a grasp study, with known numbers."""

from __future__ import annotations

import numpy as np

from firstcontact.core.physics import GRAVITY
from firstcontact.testing import make_estimate
from firstcontact_lab.grasping._judgement import conditions, household_policies
from firstcontact_lab.grasping._picks import Pick
from firstcontact_lab.grasping._table import DETECTION, LIFTS, Branches, Branching, ClosingTable
from firstcontact_lab.grasping.page import GRASP_PARTS, HOUSEHOLD, grasp_page
from firstcontact_lab.grasping.results import (
    Between,
    ChosenSettings,
    Estimates,
    FrontPoints,
    Household,
    ObjectErrors,
    RealClosings,
    Reflexes,
    ReflexSuccess,
    TunedOn,
)
from firstcontact_lab.report.findings import Findings, State
from firstcontact_lab.report.results import NOTHING

HOW = Branching((0.10,), (1.0, 2.0, 4.0, 8.0), (2.0,))
#: Kind, force that just holds it, N, and force that damages it, N.
THINGS = {
    "raspberry": (0.1, 3.0), "silken tofu, 4 cm cube": (0.5, 3.0), "sponge, dry": (0.3, np.inf),
    "quail egg": (0.5, 20.0), "soup can": (6.0, np.inf), "wood block": (6.0, np.inf),
    "wrench": (5.0, np.inf), "hammer, at its handle": (5.0, np.inf),
}  # fmt: skip
SHORE = {"raspberry": 5.0, "silken tofu, 4 cm cube": 3.0, "sponge, dry": 3.0}


def branch(kind: str, hand: int, specimen: int = 1) -> Branches:
    """Return a pick with each final force. The hand obeys commands; its reflex holds with 9 N."""
    holds, limit = THINGS[kind]
    forces = np.array(HOW.forces)
    slips = forces < holds
    shape = (len(LIFTS), len(DETECTION), 1, len(forces))
    shore = SHORE.get(kind, 75.0)
    return Branches(
        Pick(kind, hand, specimen), 0.10, 2 * holds * 0.5 / GRAVITY, 0.5, limit,
        make_estimate(shore, shore - 5, shore + 5, 0.01), (), 0.02,
        forces, 2 * forces,
        np.broadcast_to(np.where(slips, 9.0, np.nan), shape).copy(),
        np.broadcast_to(np.where(slips, 0.0, np.nan), shape).copy(),
    )  # fmt: skip


def table(hands: tuple[int, ...]) -> ClosingTable:
    """Return a table of picks of all objects by these hands."""
    return ClosingTable.from_branches(
        [branch(kind, hand) for kind in THINGS for hand in hands], HOW
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


def state() -> State:
    """Return the state of a whole study."""
    return State(
        command="firstcontact grasp-study <b>",
        settings={"seed": 3, "workers": 2},
        options={},
        parts=GRASP_PARTS,
        page=grasp_page,
        quick=True,
        findings=[Findings("twin", NOTHING.replace([HOUSEHOLD(household())]))],
    )
