"""Benchmark of any regressor and of firstcontact's estimators, on the same rigs and splits."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from firstcontact.core import Record, Runner
from firstcontact.models import ESTIMATORS, Predictions
from firstcontact.twin import condition
from firstcontact_lab.study._comparison import (
    BRIEF,
    HOME,
    NETWORK,
    Generalised,
    compared,
    rig_sets,
    sides,
)
from firstcontact_lab.study._entrants import Entrant, fit_on_set
from firstcontact_lab.study._rig_sets import RigSet, Sizes, Use
from firstcontact_lab.study.scores import (
    AnytimeScores,
    anytime_scores,
    join_by_time,
    predictions_by_time,
)
from firstcontact_lab.study.settings import StudySettings

#: Delays of the contacts in samples, drawn at random: about those of detectors on the twin.
LATE = (0, 0, 1, 1, 1, 2, 2, 2, 3, 3, 4)


class Benchmarked(Record, frozen=True, kw_only=True):
    """Scores of all competitors in one condition of the twin."""

    generalise: Generalised
    anytime: dict[str, AnytimeScores]


@dataclass(frozen=True, slots=True)
class Size:
    """Size of a benchmark: seeds of the sets, and numbers of pinches in a set."""

    seeds: tuple[int, ...] = StudySettings().rig_seeds
    sizes: Sizes = field(default_factory=Sizes)


#: Size of a quick benchmark.
QUICK = Size((StudySettings().rig_seeds[0],), BRIEF)


def contender(name: str) -> Entrant:
    """Return the competitor with a name: a registered estimator, or ``PACKAGE:NAME``."""
    ESTIMATORS.find(name)
    if ":" in name:
        return Entrant(name, "anybody", {"regressor": name})
    return Entrant(name, "trained", {"estimator": name})


def competitors(name: str) -> list[Entrant]:
    """Return the named competitor, the default estimator, and the network's variants."""
    query, usual = contender(name), contender(ESTIMATORS.default)
    return [query, *([] if query == usual else [usual]), *NETWORK]


def benchmark(
    name: str,
    conditions: Sequence[str],
    size: Size,
    seed: int,
    runner: Runner,
    say: Callable[[str], object] = lambda line: None,
) -> Mapping[str, Benchmarked]:
    """Compare an estimator with the default estimator and the network on the same data."""
    everybody = competitors(name)
    out = {}
    for condition_name in conditions:
        sets = rig_sets(size.seeds, condition(condition_name), size.sizes, LATE, runner)
        seeds = ", ".join(map(str, size.seeds))
        say(f"{condition_name}: made sets of {len(sets[0].touches)} contacts, seeds {seeds}")
        generalised = compared(lambda place: everybody, sets, size.seeds, seed, runner)
        timed = [e for e in everybody if e is not NETWORK[-1]]
        answers = runner.map(_timed, [(e, p) for e in timed for p in range(len(sets))], sets, seed)
        out[condition_name] = Benchmarked(
            generalise=generalised,
            anytime={
                e.name: _scores(answers[n * len(sets) : (n + 1) * len(sets)], sets, seed)
                for n, e in enumerate(timed)
            },
        )
    return out


def _timed(query: tuple[Entrant, int], sets: Sequence[RigSet], seed: int) -> dict[int, Predictions]:
    """Return predictions for the unseen objects of a set, by the time after the contact."""
    entrant, place = query
    name = sets[place]
    learn, _ = sides(name, HOME)
    model = fit_on_set(entrant, name, learn, seed)
    return predictions_by_time(model, name.touches.take(name.indices(Use.OBJECTS)))


def _scores(
    by_set: Sequence[Mapping[int, Predictions]], sets: Sequence[RigSet], seed: int
) -> AnytimeScores:
    objects = [rig_data.windows.take(rig_data.indices(Use.OBJECTS)) for rig_data in sets]
    truth = np.concatenate([windows.y for windows in objects])
    # An object has much of its error on all rigs: the rigs together have only as many clusters.
    names = np.concatenate([windows.objects for windows in objects])
    return anytime_scores(join_by_time(by_set), truth, names, seed)
