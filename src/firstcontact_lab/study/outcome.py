"""Sentences that state the outcome of a study, from its results."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from firstcontact.core import percent
from firstcontact.models import ESTIMATORS
from firstcontact_lab.report import names
from firstcontact_lab.report.results import SubjectResults
from firstcontact_lab.report.tables import ERROR_TOLERANCE, SHARE_TOLERANCE, number
from firstcontact_lab.study.part import Subjects
from firstcontact_lab.study.parts.blocks import BLOCKS, LEVEL, RANDOM
from firstcontact_lab.study.parts.blocks import PUBLISHED as ACCURACIES
from firstcontact_lab.study.parts.in_force import IN_FORCE
from firstcontact_lab.study.parts.objects import OBJECTS
from firstcontact_lab.study.parts.objects import PUBLISHED as ERRORS

#: Baseline that the outcome of a left-out level is compared with.
PEAK = "peak"
Scored = Mapping[str, float]


def outcome(subjects: Subjects) -> list[str]:
    """Return the outcome on blocks, on what was not in the training, and on the time.

    Topics without results are left out.
    """
    blocks = _about(
        "Accuracy on blocks (random 90/10)",
        subjects,
        lambda results: _judged(
            _accuracies(results), ACCURACIES, lambda x, paper: x >= paper - SHARE_TOLERANCE, percent
        ),
    )
    objects = _about(
        "Unseen objects, RMSE in Shore A",
        subjects,
        lambda results: _judged(
            _errors(results), ERRORS, lambda x, paper: x <= (1 + ERROR_TOLERANCE) * paper, _shore
        ),
    )
    level = _about("RMSE with one block level left out of training", subjects, _level_left_out)
    time = _about(
        "Pinches with an estimate ready when the second finger touches", subjects, _in_force
    )
    return [text for text in (blocks, f"{objects} {level}".strip(), time) if text]


def _about(topic: str, subjects: Subjects, describe: Callable[[SubjectResults], str]) -> str:
    """Return a sentence with the description of each subject that has one; or ""."""
    texts = {title: text for title, results in subjects.items() if (text := describe(results))}
    several = len(subjects) > 1
    listed = "; ".join(f"{title.lower()} {t}" if several else t for title, t in texts.items())
    return f"{topic}: {listed}." if listed else ""


def _judged(
    scores: Scored,
    published: Scored,
    is_as_good: Callable[[float, float], bool],
    form: Callable[[float], str],
) -> str:
    """Return a comparison of an estimator's scores with the published ones; "" without scores."""
    if not scores:
        return ""
    good = all(is_as_good(value, published[name]) for name, value in scores.items())
    listed = ", ".join(
        f"{names.estimator(name).title} {form(value)} against {form(published[name])}"
        for name, value in scores.items()
    )
    return f"{'as good as' if good else 'worse than'} published ({listed})"


def _accuracies(results: SubjectResults) -> Scored:
    splits = {name: scores.split(RANDOM) for name, scores in results[BLOCKS].items()}
    return {
        name: scores.accuracy
        for name in ACCURACIES
        if (scores := splits.get(name)) and scores.accuracy is not None
    }


def _errors(results: SubjectResults) -> Scored:
    return {name: results[OBJECTS][name].rmse for name in ERRORS if name in results[OBJECTS]}


def _level_left_out(results: SubjectResults) -> str:
    """Return the RMSE of default estimator, peak amplitude and best estimator."""
    errors = {
        name: split.rmse
        for name, scores in results[BLOCKS].items()
        if (split := scores.split(LEVEL)) and split.rmse is not None
    }
    if ESTIMATORS.default not in errors:
        return ""
    best = min(errors, key=lambda name: errors[name])
    chosen = [name for name in (ESTIMATORS.default, PEAK, best) if name in errors]
    return ", ".join(
        f"{names.estimator(name).title} {_shore(errors[name])}" for name in dict.fromkeys(chosen)
    )


def _in_force(results: SubjectResults) -> str:
    scores = results[IN_FORCE]
    return "" if scores is None else percent(scores.share)


def _shore(value: float) -> str:
    return number(value, 1)
