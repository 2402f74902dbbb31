"""Comparison of estimators beyond their training blocks, for the study part ``generalise``.

All estimators get the same simulated rigs.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Record
from firstcontact.core.physics import gent_shore_a
from firstcontact.jobs import Runner
from firstcontact.models import ESTIMATORS, Task
from firstcontact.models.interval import SHORE_A
from firstcontact.models.model_file import pretrained
from firstcontact.models.predictions import TouchPredictor
from firstcontact.models.rig.network_estimator import rig_estimators
from firstcontact.models.training import fit_model
from firstcontact.models.training_runs import RIG_ESTIMATOR
from firstcontact.twin.draw import Condition
from firstcontact_lab.study.off_blocks import OffBlocks, RigSetPredictions, score_off_blocks
from firstcontact_lab.study.rig_sets import PinchUse, RigSet, Sizes, rig_set
from firstcontact_lab.study.window_ladder import fit_window_ladder

Index = NDArray[np.intp]
Values = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Competitor:
    name: str
    method: str
    options: Mapping[str, Any] = field(default_factory=dict)


#: Shore A levels that are left out in turn.
LEVELS = (20.0, 29.0, 43.0)
BRIEF = Sizes(blocks=16, held_out=4, objects=6, other_blocks=6, kinds=16)
#: Names of the questions, besides those that leave out a level of Shore A.
HOME, OTHER, FLOOR = "home", "other hand", "floor"

#: Ceilings (competitors with additional knowledge), and floor (trained on the same kinds of object
#: on the same rig).
CEILINGS = (Competitor("modulus", "modulus"), Competitor("contact_stiffness", "stiffness"))
#: Default estimator with the network's inputs: no samples after the second contact.
MASKED = Competitor("masked", "any time", {"estimator": ESTIMATORS.default})
AT_HOME = Competitor("floor", "window", {"estimator": ESTIMATORS.default})
#: The default any-time estimator, and the in-context network without and with the radius given.
NETWORK = (
    Competitor(RIG_ESTIMATOR.name, "in context", {"estimator": RIG_ESTIMATOR.name}),
    Competitor("in_context", "in context", {"estimator": "network"}),
    Competitor("in_context_radius", "in context", {"estimator": "network", "radii": True}),
)


class Generalised(Record, frozen=True, kw_only=True):
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
    return runner.map(rig_set, list(seeds), condition, sizes, late)


def fit_on_set(competitor: Competitor, rigs: RigSet, learn: Index, seed: int) -> TouchPredictor:
    touches, name = rigs.touches.take(learn), competitor.options["estimator"]
    shore_a, groups = rigs.windows.y[learn], rigs.windows.sessions[learn]
    if competitor.method == "in context":
        return rig_estimators()[name].adapt(pretrained(), touches, shore_a, groups, seed).model
    return fit_window_ladder(name, touches, shore_a, groups, seed=seed)


@dataclass(frozen=True, slots=True, eq=False)
class Query:
    competitor: Competitor
    place: int
    question: str
    learn: Index
    ask: Index


def answer(query: Query, sets: Sequence[RigSet], seed: int) -> Values:
    """Train the estimator of a query, and return the Shore A that it predicts.

    The result has one value for each pinch in ``query.ask``.
    """
    competitor, rigs, learn, ask = query.competitor, sets[query.place], query.learn, query.ask
    if competitor.method == "window":
        options = dict(competitor.options)
        name, X = options.pop("estimator"), rigs.windows.X[ask]
        model = fit_model(rigs.windows.take(learn), name, Task.REGRESSION, seed, options)
        return model.predict(X).astype(np.float64)
    if competitor.method == "modulus":  # Gent's formula
        return np.array([gent_shore_a(modulus) for modulus in rigs.moduli[ask]])
    if competitor.method == "stiffness":  # a parabola in the logarithm of the contact stiffness
        logarithms, shore_a = np.log(rigs.stiffnesses), rigs.windows.y[learn]
        degree = min(2, len(np.unique(shore_a)) - 1)
        line = np.polynomial.Polynomial.fit(logarithms[learn], shore_a, degree)
        return np.asarray(np.clip(line(logarithms[ask]), *SHORE_A))
    touches = rigs.touches.take(ask)
    if competitor.options.get("radii"):
        touches = replace(touches, radii=rigs.radii[ask])
    return fit_on_set(competitor, rigs, learn, seed).predict_touches(touches).value


def compared(
    competitors: Callable[[int], Sequence[Competitor]],
    sets: Sequence[RigSet],
    seeds: Sequence[int],
    seed: int,
    runner: Runner,
) -> Generalised:
    queries = [
        Query(competitor, place, question, *learn_and_ask_indices(rigs, question))
        for place, rigs in enumerate(sets)
        for competitor in (*competitors(place), *CEILINGS, AT_HOME)
        for question in _questions(competitor)
    ]
    # Start the longest queries first, so that none of them runs alone at the end.
    order = sorted(queries, key=lambda query: not _is_slow(query.competitor))
    answers = dict(zip(map(id, order), runner.map(answer, order, sets, seed), strict=True))
    rows: dict[str, list[RigSetPredictions]] = {}
    options: dict[str, Mapping[str, object]] = {}
    for query in queries:
        rigs, name = sets[query.place], query.competitor.name
        windows, uses = rigs.windows.take(query.ask), rigs.uses[query.ask]
        answered = RigSetPredictions(query.question, query.place, windows, uses, answers[id(query)])
        rows.setdefault(name, []).append(answered)
        options[name] = {k: v for k, v in query.competitor.options.items() if k not in _OWN}
    scores = {name: score_off_blocks(rows[name], options[name], seed) for name in rows}
    return Generalised(
        sets=len(sets),
        seeds=list(seeds),
        pinches={use.value: int(np.mean([len(s.indices(use)) for s in sets])) for use in PinchUse},
        too_short=float(np.mean([rigs.too_short for rigs in sets])),
        floor=scores.pop(AT_HOME.name),
        ceiling={reference.name: scores.pop(reference.name) for reference in CEILINGS},
        estimators=scores,
    )


#: Options that identify a competitor, and do not describe its training.
_OWN = ("estimator", "radii")


def learn_and_ask_indices(
    rig_data: RigSet, question: str
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return (indices of pinches to learn from, indices of pinches to predict) for a question.

    ``question`` is one of the constants of this module, or the Shore A of the blocks to leave out.
    """
    home = rig_data.indices(PinchUse.BLOCKS)
    if question == HOME:
        return home, np.concatenate(
            [rig_data.indices(PinchUse.HELD), rig_data.indices(PinchUse.OBJECTS)]
        )
    if question == OTHER:
        return rig_data.indices(PinchUse.OTHER_BLOCKS), rig_data.indices(PinchUse.OTHER_OBJECTS)
    if question == FLOOR:
        return rig_data.indices(PinchUse.KINDS), rig_data.indices(PinchUse.OBJECTS)
    left = rig_data.windows.y[home] == float(question)
    return home[~left], home[left]


def _is_slow(competitor: Competitor) -> bool:
    name = competitor.options.get("estimator")
    return name is not None and ESTIMATORS[name].slow


def _questions(competitor: Competitor) -> list[str]:
    if competitor is AT_HOME:
        return [FLOOR]
    return [HOME, OTHER, *(f"{level:g}" for level in LEVELS)]
