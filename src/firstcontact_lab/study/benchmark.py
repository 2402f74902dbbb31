"""Anybody's regressor beside ours: the same rigs, splits, times and intervals."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from firstcontact.core import Runner
from firstcontact.models import (
    ESTIMATORS,
    Answers,
    AnytimeScores,
    answers_by_time,
    anytime_scores,
    joined_answers,
)
from firstcontact.twin import condition
from firstcontact_lab.report.results.benchmark import Benchmarked
from firstcontact_lab.study._comparison import BRIEF, HOME, NETWORK, compared, rig_sets, sides
from firstcontact_lab.study._entrants import Entrant, fit_on_set
from firstcontact_lab.study._rig_sets import RigSet, Sizes, Use
from firstcontact_lab.study.settings import StudySettings

#: Contacts are as late as one of these, samples: about what detectors do on the twin.
LATE = (0, 0, 1, 1, 1, 2, 2, 2, 3, 3, 4)


@dataclass(frozen=True, slots=True)
class Size:
    """Seeds of the sets, and how many pinches each has."""

    seeds: tuple[int, ...] = StudySettings().rig_seeds
    sizes: Sizes = field(default_factory=Sizes)


#: For a first look.
QUICK = Size((StudySettings().rig_seeds[0],), BRIEF)


def contender(name: str) -> Entrant:
    """Who is named: a registered estimator, or a class or an instance as ``PACKAGE:NAME``.

    Raises
    ------
    InputError
        Nobody of that name.
    """
    ESTIMATORS.find(name)
    if ":" in name:
        return Entrant(name, "anybody", {"regressor": name})
    return Entrant(name, "trained", {"estimator": name})


def competitors(name: str) -> list[Entrant]:
    """Return the contender, the default estimator and the in-context network in both forms."""
    asked, usual = contender(name), contender(ESTIMATORS.default)
    return [asked, *([] if asked == usual else [usual]), *NETWORK]


def benchmark(
    name: str,
    conditions: Sequence[str],
    size: Size,
    seed: int,
    runner: Runner,
    say: Callable[[str], object] = lambda line: None,
) -> Mapping[str, Benchmarked]:
    """Ask somebody, the default estimator and the in-context network the same.

    Parameters
    ----------
    name
        As of :func:`contender`.
    conditions
        Of the twin.
    size
        Which sets.
    seed
        Of trainings and bootstrap intervals.
    runner
        Makes sets and trainings.
    say
        Called with what is done.

    Raises
    ------
    InputError
        Nobody of that name, or answers that are none.
    """
    everybody = competitors(name)
    out = {}
    for its in conditions:
        sets = rig_sets(size.seeds, condition(its), size.sizes, LATE, runner)
        seeds = ", ".join(map(str, size.seeds))
        say(f"{its}: sets of {len(sets[0].touches)} contacts are made, seeds {seeds}")
        found = compared(lambda place: everybody, sets, size.seeds, seed, runner)
        timed = [e for e in everybody if e is not NETWORK[1]]
        answers = runner.map(_timed, [(e, p) for e in timed for p in range(len(sets))], sets, seed)
        out[its] = Benchmarked(
            generalise=found,
            anytime={
                e.name: _scores(answers[n * len(sets) : (n + 1) * len(sets)], sets, seed)
                for n, e in enumerate(timed)
            },
        )
    return out


def _timed(asked: tuple[Entrant, int], sets: Sequence[RigSet], seed: int) -> dict[int, Answers]:
    """Answers about the unseen objects of a set, by the time after the contact."""
    entrant, place = asked
    its = sets[place]
    learn, _ = sides(its, HOME)
    model = fit_on_set(entrant, its, learn, seed)
    return answers_by_time(model, its.touches.take(its.where(Use.OBJECTS)))


def _scores(
    by_set: Sequence[Mapping[int, Answers]], sets: Sequence[RigSet], seed: int
) -> AnytimeScores:
    objects = [its.windows.take(its.where(Use.OBJECTS)) for its in sets]
    joined = {ms: joined_answers([answers[ms] for answers in by_set]) for ms in by_set[0]}
    truth = np.concatenate([windows.y for windows in objects])
    specimens = np.concatenate(
        [[f"{place} {name}" for name in its.specimens] for place, its in enumerate(objects)]
    )
    return anytime_scores(joined, truth, specimens, seed)
