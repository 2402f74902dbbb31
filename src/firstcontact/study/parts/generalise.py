"""Estimators off their blocks: unseen objects, another hand, a level left out, on many rigs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from firstcontact.core.extras import absent
from firstcontact.core.jobs import Runner
from firstcontact.learning.detection import TOLERANCE, outcome
from firstcontact.report.figures.generalise import generalise_figure
from firstcontact.report.findings import PartResult
from firstcontact.report.results.anytime import Generalised
from firstcontact.report.results.study import SubjectResults
from firstcontact.stiffness import ESTIMATORS, Task
from firstcontact.study._entrants import Asked, Entrant, answer
from firstcontact.study._off_blocks import Answered, off_blocks
from firstcontact.study._rig_sets import RigSet, Sizes, Use, rig_set
from firstcontact.study._subject import Subject
from firstcontact.study.settings import StudySettings
from firstcontact.twin.conditions import CONDITIONS, Condition

#: Levels that are left out, one after the other, Shore A.
LEVELS = (20.0, 29.0, 43.0)
#: Slow estimators are asked on so many sets only, learning quickly.
SLOW_SETS = 1
BRIEF = Sizes(blocks=16, held=4, objects=6, other_blocks=6, kinds=16)
#: Questions besides the levels that are left out.
HOME, OTHER, FLOOR = "home", "other hand", "floor"

_CEILING = (
    Entrant("modulus", "told the modulus"),
    Entrant("contact_stiffness", "told the stiffness"),
)
_FLOOR = Entrant("floor", "trained", {"estimator": ESTIMATORS.default})


def generalise(subject: Subject, settings: StudySettings, runner: Runner) -> PartResult:
    """Ask everybody the same on sets of the twin that no choice was made on.

    Contacts are as late as the detector placed this subject's own, where it was right; pinches
    whose second contact leaves no answer are asked of nobody.
    """
    if subject.name not in CONDITIONS:
        return PartResult()
    condition = CONDITIONS[subject.name]
    sizes = BRIEF if settings.brief else Sizes()
    late = _late(subject, settings.early)
    sets = runner.map(_made, list(settings.rig_seeds), condition, sizes, late)
    places = [
        (entrant, place, question)
        for place, its in enumerate(sets)
        for entrant in _entrants(settings, place)
        for question in _questions(entrant)
    ]
    asked = [
        Asked(entrant, place, *_sides(sets[place], question)) for entrant, place, question in places
    ]
    # What takes longest first, so that nobody waits for it at the end.
    order = sorted(range(len(asked)), key=lambda i: not _slow(asked[i].entrant))
    found = runner.map(answer, [asked[i] for i in order], sets, settings.seed)
    answers = dict(zip(order, found, strict=True))
    rows: dict[str, list[Answered]] = {}
    options: dict[str, Mapping[str, object]] = {}
    for number, (entrant, place, question) in enumerate(places):
        its, told = sets[place], asked[number].ask
        rows.setdefault(entrant.name, []).append(
            Answered(question, place, its.windows.take(told), its.uses[told], answers[number])
        )
        options[entrant.name] = {k: v for k, v in entrant.options.items() if k not in _OWN}
    scores = {name: off_blocks(rows[name], options[name], settings.seed) for name in rows}
    results = Generalised(
        sets=len(sets),
        seeds=list(settings.rig_seeds),
        pinches={use.value: int(np.mean([len(s.where(use)) for s in sets])) for use in Use},
        too_short=float(np.mean([its.too_short for its in sets])),
        floor=scores.pop(_FLOOR.name),
        ceiling={told.name: scores.pop(told.name) for told in _CEILING},
        estimators=scores,
    )
    return PartResult(SubjectResults(generalise=results), [generalise_figure(results)])


#: Options that say who an entrant is, not how it learned.
_OWN = ("estimator", "radii")


def _made(seed: int, condition: Condition, sizes: Sizes, late: Sequence[int]) -> RigSet:
    return rig_set(seed, condition, sizes, late)


def _entrants(settings: StudySettings, place: int) -> list[Entrant]:
    """Everybody that is asked about a set."""
    out = []
    for name, entry in ESTIMATORS.items():
        if entry.baseline or Task.REGRESSION not in entry.tasks or absent(entry.modules):
            continue
        if entry.slow and (settings.brief or place >= SLOW_SETS):
            continue
        options = entry.quick if entry.slow or settings.brief else {}
        out.append(Entrant(name, "trained", {"estimator": name, **options}))
    network = [
        Entrant("in_context", "in context"),
        Entrant("in_context_radius", "in context", {"radii": True}),
    ]
    return [*out, *network, *_CEILING, _FLOOR]


def _slow(entrant: Entrant) -> bool:
    name = entrant.options.get("estimator")
    return name is not None and ESTIMATORS[name].slow


def _questions(entrant: Entrant) -> list[str]:
    if entrant is _FLOOR:
        return [FLOOR]
    return [HOME, OTHER, *(f"{level:g}" for level in LEVELS)]


def _sides(its: RigSet, question: str) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
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


def _late(subject: Subject, early: float) -> list[int]:
    """How late the detector placed this subject's contacts, samples; where it was right."""
    pairs = zip(subject.dataset.pinches, subject.starts, strict=True)
    late = [
        contact.sample - pinch.first.sample
        for pinch, contact in pairs
        if contact is not None
        and pinch.first is not None
        and outcome(contact, pinch.first, pinch.layout.rate, early, TOLERANCE) == "success"
    ]
    return late or [0]
