"""How good the live estimates were on judged picks, object by object, and when they came."""

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

#: Windows, s.
WINDOWS = (0.003, 0.005, 0.008, 0.015)
USED = "used"
#: The firmest block has 60 Shore A; the network was never trained on much firmer things.
FIRMEST = 70.0
#: A window is a whole number of samples: it may be half of one shorter.
HALF = 1e-4


def at_tuned_speed(tables: Tables, rows: Sequence[Branches], ours: Judged) -> list[Branches]:
    """Of each pick the approach that was tuned for those that act on the estimate."""
    fold_of = folds(sorted(set(tables.judged.kinds)), tables.folds)
    speed = [chosen.settings["approach"] for chosen in ours.chosen]
    return [row for row in rows if row.speed == speed[fold_of[row.pick.kind]]]


def _errors(rows: Sequence[Branches]) -> dict[str, list[float]]:
    """Estimate less label, by window in ms and as used."""
    found: dict[str, list[float]] = {f"{1e3 * w:g}": [] for w in WINDOWS}
    found[USED] = []
    for row in rows:
        label = household_named(row.pick.kind).numbers.shore_a.value
        for window in WINDOWS:
            whole = [a for a in row.answers if abs(a.duration - window) < 5e-4 + HALF]
            if whole:
                nearest = min(whole, key=lambda a: abs(a.duration - window))
                found[f"{1e3 * window:g}"].append(nearest.value - label)
        if row.told is not None:
            found[USED].append(row.told.value - label)
    return found


def _rmse(errors: Mapping[str, Sequence[float]]) -> dict[str, float]:
    return {w: float(np.sqrt(np.mean(np.square(e)))) for w, e in errors.items() if len(e)}


def estimates(
    tables: Tables,
    rows: Sequence[Branches],
    ours: Judged,
    own: Mapping[tuple[int, float], OwnHand],
) -> Estimates:
    """Over all judged picks."""
    its = at_tuned_speed(tables, rows, ours)
    within = [r for r in its if household_named(r.pick.kind).numbers.shore_a.value <= FIRMEST]
    longest = [max((a.duration for a in r.answers), default=0.0) for r in its]
    hands = {(r.pick.hand, r.speed) for r in its}
    return Estimates(
        rmse=_rmse(_errors(its)),
        bearing=_rmse(_errors(within)),
        decided={f"{1e3 * w:g}": float(np.mean([d >= w - 5e-4 for d in longest])) for w in WINDOWS},
        block_rmse=float(np.sqrt(np.mean([own[h].rmse ** 2 for h in sorted(hands)]))),
        unanswered=float(np.mean([r.told is None for r in its])),
        heard=float(np.mean([r.heard is not None for r in its])),
    )


def by_object(
    tables: Tables, rows: Sequence[Branches], policies: Mapping[str, Judged]
) -> dict[str, ObjectErrors]:
    """Of each object: errors, and how often it was dropped and damaged by policies as tuned."""
    ours = list(policies.values())[-1]
    its = at_tuned_speed(tables, rows, ours)
    found = {}
    for kind in dict.fromkeys(row.pick.kind for row in its):
        mine = [row for row in its if row.pick.kind == kind]
        errors = _errors(mine)
        which = tables.judged.kinds == kind
        numbers = household_named(kind).numbers
        found[kind] = ObjectErrors(
            shore_a=numbers.shore_a.value,
            family=family(kind),
            fragile=numbers.limit is not None,
            n=len(mine),
            answered=len(errors[USED]),
            rmse=_rmse(errors),
            bias=float(np.mean(errors[USED])) if errors[USED] else None,
            drops={n: float(p.outcomes.dropped[TUNED, which].mean()) for n, p in policies.items()},
            damage={n: float(p.outcomes.damaged[TUNED, which].mean()) for n, p in policies.items()},
        )
    return found
