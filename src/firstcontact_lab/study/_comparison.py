"""Comparison of estimators for study and benchmark: all get the same simulated rigs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Record, Runner
from firstcontact.models import ESTIMATORS, RIG_ESTIMATOR
from firstcontact.twin import Condition
from firstcontact_lab.study._entrants import Entrant, Query, answer
from firstcontact_lab.study._off_blocks import Answered, OffBlocks, off_blocks
from firstcontact_lab.study._rig_sets import RigSet, Sizes, Use, rig_set

#: Shore A levels that are left out in turn.
LEVELS = (20.0, 29.0, 43.0)
BRIEF = Sizes(blocks=16, held_out=4, objects=6, other_blocks=6, kinds=16)
#: Names of the questions, besides those that leave out a level of Shore A.
HOME, OTHER, FLOOR = "home", "other hand", "floor"

#: Ceilings (competitors with additional knowledge), and floor (trained on the same kinds of object
#: on the same rig).
TOLD = (
    Entrant("modulus", "told the modulus"),
    Entrant("contact_stiffness", "told the stiffness"),
)
#: Default estimator with the network's inputs: no samples after the second contact.
MASKED = Entrant("masked", "anybody", {"estimator": ESTIMATORS.default})
AT_HOME = Entrant("floor", "trained", {"estimator": ESTIMATORS.default})
#: The default any-time estimator, and the in-context network without and with the radius given.
NETWORK = (
    Entrant(RIG_ESTIMATOR.name, "in context", {"estimator": RIG_ESTIMATOR.name}),
    Entrant("in_context", "in context", {"estimator": "network"}),
    Entrant("in_context_radius", "in context", {"estimator": "network", "radii": True}),
)


class Generalised(Record, frozen=True, kw_only=True):
    """Scores of competitors on simulated rigs that no other part of the project uses."""

    sets: int
    seeds: list[int]
    pinches: dict[str, int]
    too_short: float
    floor: OffBlocks
    ceiling: dict[str, OffBlocks]
    estimators: dict[str, OffBlocks]


def rig_sets(
    seeds: Sequence[int], condition: Condition, sizes: Sizes, late: Sequence[int], runner: Runner
) -> list[RigSet]:
    """Return one set of pinches per seed; see :func:`firstcontact_lab.study._rig_sets.rig_set`."""
    return runner.map(_made, list(seeds), condition, sizes, late)


def compared(
    entrants: Callable[[int], Sequence[Entrant]],
    sets: Sequence[RigSet],
    seeds: Sequence[int],
    seed: int,
    runner: Runner,
) -> Generalised:
    """Return the scores of all competitors over all sets."""
    places = [
        (entrant, place, question)
        for place, rig_data in enumerate(sets)
        for entrant in (*entrants(place), *TOLD, AT_HOME)
        for question in _questions(entrant)
    ]
    queries = [
        Query(entrant, place, *sides(sets[place], question)) for entrant, place, question in places
    ]
    # Start the longest queries first, so that none of them runs alone at the end.
    order = sorted(range(len(queries)), key=lambda i: not _slow(queries[i].entrant))
    predictions = runner.map(answer, [queries[i] for i in order], sets, seed)
    answers = dict(zip(order, predictions, strict=True))
    rows: dict[str, list[Answered]] = {}
    options: dict[str, Mapping[str, object]] = {}
    for number, (entrant, place, question) in enumerate(places):
        rig_data, reference = sets[place], queries[number].ask
        rows.setdefault(entrant.name, []).append(
            Answered(
                question,
                place,
                rig_data.windows.take(reference),
                rig_data.uses[reference],
                answers[number],
            )
        )
        options[entrant.name] = {k: v for k, v in entrant.options.items() if k not in _OWN}
    scores = {name: off_blocks(rows[name], options[name], seed) for name in rows}
    return Generalised(
        sets=len(sets),
        seeds=list(seeds),
        pinches={use.value: int(np.mean([len(s.indices(use)) for s in sets])) for use in Use},
        too_short=float(np.mean([rig_data.too_short for rig_data in sets])),
        floor=scores.pop(AT_HOME.name),
        ceiling={reference.name: scores.pop(reference.name) for reference in TOLD},
        estimators=scores,
    )


#: Options that identify a competitor, and do not describe its training.
_OWN = ("estimator", "radii", "regressor")


def sides(rig_data: RigSet, question: str) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return indices of the pinches to learn from, and of those to predict, for a question."""
    home = rig_data.indices(Use.BLOCKS)
    if question == HOME:
        return home, np.concatenate([rig_data.indices(Use.HELD), rig_data.indices(Use.OBJECTS)])
    if question == OTHER:
        return rig_data.indices(Use.OTHER_BLOCKS), rig_data.indices(Use.OTHER_OBJECTS)
    if question == FLOOR:
        return rig_data.indices(Use.KINDS), rig_data.indices(Use.OBJECTS)
    left = rig_data.windows.y[home] == float(question)
    return home[~left], home[left]


def _made(seed: int, condition: Condition, sizes: Sizes, late: Sequence[int]) -> RigSet:
    return rig_set(seed, condition, sizes, late)


def _slow(entrant: Entrant) -> bool:
    name = entrant.options.get("estimator")
    return name is not None and ESTIMATORS[name].slow


def _questions(entrant: Entrant) -> list[str]:
    if entrant is AT_HOME:
        return [FLOOR]
    return [HOME, OTHER, *(f"{level:g}" for level in LEVELS)]
