"""Estimators off their blocks: unseen objects, another hand, a level left out, on many rigs."""

from __future__ import annotations

from functools import partial

from firstcontact.core import Runner, missing_modules
from firstcontact.models import TOLERANCE, Task, outcome, window_estimators
from firstcontact.twin import CONDITIONS
from firstcontact_lab.report.figures.generalise import generalise_figure
from firstcontact_lab.report.findings import PartResult
from firstcontact_lab.report.results.study import SubjectResults
from firstcontact_lab.study._comparison import BRIEF, MASKED, NETWORK, compared, rig_sets
from firstcontact_lab.study._entrants import Entrant
from firstcontact_lab.study._rig_sets import Sizes
from firstcontact_lab.study._subject import Subject
from firstcontact_lab.study.settings import StudySettings

#: Slow estimators are asked on so many sets only, learning quickly.
SLOW_SETS = 1


def generalise(subject: Subject, settings: StudySettings, runner: Runner) -> PartResult:
    """Ask everybody the same on sets of the twin that no choice was made on.

    Contacts are as late as the detector placed this subject's own, where it was right; pinches
    whose second contact leaves no answer are asked of nobody.
    """
    if subject.name not in CONDITIONS:
        return PartResult()
    sizes = BRIEF if settings.brief else Sizes()
    late = _late(subject, settings.early)
    seeds = settings.rig_seeds
    sets = rig_sets(seeds, CONDITIONS[subject.name], sizes, late, runner)
    results = compared(partial(_entrants, settings), sets, seeds, settings.seed, runner)
    return PartResult(SubjectResults(generalise=results), [generalise_figure(results)])


def _entrants(settings: StudySettings, place: int) -> list[Entrant]:
    """Everybody that is asked about a set."""
    out = []
    for name, entry in window_estimators().items():
        if entry.baseline or Task.REGRESSION not in entry.tasks or missing_modules(entry.modules):
            continue
        if entry.slow and (settings.brief or place >= SLOW_SETS):
            continue
        options = entry.quick if entry.slow or settings.brief else {}
        out.append(Entrant(name, "trained", {"estimator": name, **options}))
    return [*out, MASKED, *NETWORK]


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
