"""Errors and times of the live estimates on the picks for judging, in total and by object."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from firstcontact.twin import household_named
from firstcontact_lab.grasping._branches import Branches
from firstcontact_lab.grasping._families import family, folds
from firstcontact_lab.grasping._front import TUNED
from firstcontact_lab.grasping._household_numbers import Judged, Tables
from firstcontact_lab.grasping._own_hand import OwnHand
from firstcontact_lab.grasping.results import Estimates, ObjectErrors

#: Lengths of the windows, s.
WINDOWS = (0.003, 0.005, 0.008, 0.015)
USED = "used"
#: Largest Shore A in the scores without the firmest objects: the network was not trained on objects
#: that are much firmer.
FIRMEST = 70.0
#: Tolerance for the length of a window, s, because windows have whole numbers of samples.
HALF = 1e-4


def at_tuned_speed(tables: Tables, rows: Sequence[Branches], ours: Judged) -> list[Branches]:
    """Return one closing of each pick, at the approach speed that was tuned for its object."""
    fold_of = folds(sorted(set(tables.judged.kinds)), tables.folds)
    speed = [chosen.settings["approach"] for chosen in ours.chosen]
    return [row for row in rows if row.speed == speed[fold_of[row.pick.kind]]]


def _errors(rows: Sequence[Branches]) -> dict[str, list[float]]:
    """Return the errors of estimates, in Shore A, by window length in ms and under "used"."""
    errors: dict[str, list[float]] = {f"{1e3 * w:g}": [] for w in WINDOWS}
    errors[USED] = []
    for row in rows:
        label = household_named(row.pick.kind).numbers.shore_a.value
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


def estimates(
    tables: Tables,
    rows: Sequence[Branches],
    ours: Judged,
    own_hands: Mapping[tuple[int, float], OwnHand],
) -> Estimates:
    """Return errors and times of the estimates over all picks for judging."""
    approaches = at_tuned_speed(tables, rows, ours)
    within = [
        r for r in approaches if household_named(r.pick.kind).numbers.shore_a.value <= FIRMEST
    ]
    longest = [max((a.elapsed for a in r.answers), default=0.0) for r in approaches]
    hands = {(r.pick.hand, r.speed) for r in approaches}
    return Estimates(
        rmse=_rmse(_errors(approaches)),
        bearing=_rmse(_errors(within)),
        decided={f"{1e3 * w:g}": float(np.mean([d >= w - 5e-4 for d in longest])) for w in WINDOWS},
        block_rmse=float(np.sqrt(np.mean([own_hands[h].rmse ** 2 for h in sorted(hands)]))),
        unanswered=float(np.mean([r.estimate is None for r in approaches])),
        heard=float(np.mean([r.heard is not None for r in approaches])),
    )


def by_object(
    tables: Tables, rows: Sequence[Branches], policies: Mapping[str, Judged]
) -> dict[str, ObjectErrors]:
    """Return for each object the errors of its estimates, and its drops and damage by policy."""
    ours = list(policies.values())[-1]
    approaches = at_tuned_speed(tables, rows, ours)
    errors_by_window = {}
    for kind in dict.fromkeys(row.pick.kind for row in approaches):
        mine = [row for row in approaches if row.pick.kind == kind]
        errors = _errors(mine)
        selected = tables.judged.kinds == kind
        numbers = household_named(kind).numbers
        errors_by_window[kind] = ObjectErrors(
            shore_a=numbers.shore_a.value,
            family=family(kind),
            fragile=numbers.limit is not None,
            n=len(mine),
            answered=len(errors[USED]),
            rmse=_rmse(errors),
            bias=float(np.mean(errors[USED])) if errors[USED] else None,
            drops={
                n: float(p.outcomes.dropped[TUNED, selected].mean()) for n, p in policies.items()
            },
            damage={
                n: float(p.outcomes.damaged[TUNED, selected].mean()) for n, p in policies.items()
            },
        )
    return errors_by_window
