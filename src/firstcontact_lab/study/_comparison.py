"""Everybody is asked the same about the same rigs: what studies and benchmarks share."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Runner
from firstcontact.models import ESTIMATORS
from firstcontact.twin import Condition
from firstcontact_lab.report.results.anytime import Generalised
from firstcontact_lab.study._entrants import Asked, Entrant, answer
from firstcontact_lab.study._off_blocks import Answered, off_blocks
from firstcontact_lab.study._rig_sets import RigSet, Sizes, Use, rig_set

#: Levels that are left out, one after the other, Shore A.
LEVELS = (20.0, 29.0, 43.0)
BRIEF = Sizes(blocks=16, held=4, objects=6, other_blocks=6, kinds=16)
#: Questions besides the levels that are left out.
HOME, OTHER, FLOOR = "home", "other hand", "floor"

#: Those told more, and who learned from the kinds of object on the very rig.
TOLD = (
    Entrant("modulus", "told the modulus"),
    Entrant("contact_stiffness", "told the stiffness"),
)
#: The default estimator as the network is asked: nothing after the second contact is fed to it.
MASKED = Entrant("masked", "anybody", {"estimator": ESTIMATORS.default})
AT_HOME = Entrant("floor", "trained", {"estimator": ESTIMATORS.default})
#: The in-context network, without and with the radius told.
NETWORK = (
    Entrant("in_context", "in context"),
    Entrant("in_context_radius", "in context", {"radii": True}),
)


def rig_sets(
    seeds: Sequence[int], condition: Condition, sizes: Sizes, late: Sequence[int], runner: Runner
) -> list[RigSet]:
    """A set of each seed; see :func:`firstcontact_lab.study._rig_sets.rig_set`."""
    return runner.map(_made, list(seeds), condition, sizes, late)


def compared(
    entrants: Callable[[int], Sequence[Entrant]],
    sets: Sequence[RigSet],
    seeds: Sequence[int],
    seed: int,
    runner: Runner,
) -> Generalised:
    """Scores of all entrants over all sets.

    Parameters
    ----------
    entrants
        Who is asked about the set at a place, beside those told more.
    sets, seeds
        The sets, and what they were made from.
    seed
        Of trainings and intervals.
    runner
        Does trainings.
    """
    places = [
        (entrant, place, question)
        for place, its in enumerate(sets)
        for entrant in (*entrants(place), *TOLD, AT_HOME)
        for question in _questions(entrant)
    ]
    asked = [
        Asked(entrant, place, *sides(sets[place], question)) for entrant, place, question in places
    ]
    # What takes longest first, so that nobody waits for it at the end.
    order = sorted(range(len(asked)), key=lambda i: not _slow(asked[i].entrant))
    found = runner.map(answer, [asked[i] for i in order], sets, seed)
    answers = dict(zip(order, found, strict=True))
    rows: dict[str, list[Answered]] = {}
    options: dict[str, Mapping[str, object]] = {}
    for number, (entrant, place, question) in enumerate(places):
        its, told = sets[place], asked[number].ask
        rows.setdefault(entrant.name, []).append(
            Answered(question, place, its.windows.take(told), its.uses[told], answers[number])
        )
        options[entrant.name] = {k: v for k, v in entrant.options.items() if k not in _OWN}
    scores = {name: off_blocks(rows[name], options[name], seed) for name in rows}
    return Generalised(
        sets=len(sets),
        seeds=list(seeds),
        pinches={use.value: int(np.mean([len(s.where(use)) for s in sets])) for use in Use},
        too_short=float(np.mean([its.too_short for its in sets])),
        floor=scores.pop(AT_HOME.name),
        ceiling={told.name: scores.pop(told.name) for told in TOLD},
        estimators=scores,
    )


#: Options that say who an entrant is, not how it learned.
_OWN = ("estimator", "radii", "regressor")


def sides(its: RigSet, question: str) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """What is known, and what is asked about."""
    home = its.where(Use.BLOCKS)
    if question == HOME:
        return home, np.concatenate([its.where(Use.HELD), its.where(Use.OBJECTS)])
    if question == OTHER:
        return its.where(Use.OTHER_BLOCKS), its.where(Use.OTHER_OBJECTS)
    if question == FLOOR:
        return its.where(Use.KINDS), its.where(Use.OBJECTS)
    left = its.windows.y[home] == float(question)
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
