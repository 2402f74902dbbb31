"""Report page of a study: summary, claims of the paper, and remarks on the splits."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from firstcontact.core import FileError
from firstcontact.core.records import ByName
from firstcontact.core.text import percent
from firstcontact.models import ESTIMATORS
from firstcontact_lab.report import names
from firstcontact_lab.report.findings import STUDY, Findings, StudyResults
from firstcontact_lab.report.page import Page, State
from firstcontact_lab.report.results import NOTHING, SubjectResults, read_results, subject_kind
from firstcontact_lab.report.tables import (
    ERROR_TOLERANCE,
    SHARE_TOLERANCE,
    UNITS,
    VERDICTS,
    Row,
    Table,
    claims_table,
)
from firstcontact_lab.study.part import Subjects
from firstcontact_lab.study.parts import PARTS
from firstcontact_lab.study.parts.blocks import BLOCKS, LEVEL, RANDOM
from firstcontact_lab.study.parts.blocks import PUBLISHED as ACCURACIES
from firstcontact_lab.study.parts.contacts import CONTACT, is_learned
from firstcontact_lab.study.parts.data import DATA, is_twin, kind
from firstcontact_lab.study.parts.hardness import HARDNESS
from firstcontact_lab.study.parts.in_force import IN_FORCE
from firstcontact_lab.study.parts.objects import OBJECTS
from firstcontact_lab.study.parts.objects import PUBLISHED as ERRORS


def read_study(path: Path) -> StudyResults:
    list(PARTS.values())  # loading a part defines its fields
    subject = subject_kind()
    kind: Any = ByName
    results: StudyResults = read_results(path, kind[subject, subject])
    if results.about[STUDY] is None:
        raise FileError(f"{path} has no field 'study': give the results.json of a study")
    return results


def rows(subjects: Subjects, parts: Sequence[str] = ()) -> list[Row[SubjectResults]]:
    return [row for name in parts or PARTS for row in PARTS[name].rows(subjects)]


def claims(subjects: Subjects) -> Table:
    """Return a table of the paper's claims with a verdict on each, then other main results."""
    chosen = sorted(rows(subjects), key=lambda row: not (row.claim or row.note))
    return claims_table(chosen, subjects)


def outcome(subjects: Subjects) -> list[str]:
    """Return summary sentences on errors on blocks and unseen objects, and on estimates in time."""
    blocks = _sentence("Accuracy on blocks (random 90/10)", subjects, _on_blocks)
    objects = _sentence("Unseen objects, RMSE in Shore A", subjects, _on_objects)
    left_out = _sentence("RMSE with one block level left out of training", subjects, _left_out)
    at_second = "Pinches with an estimate ready when the second finger touches"
    ready = _sentence(at_second, subjects, _ready)
    return [text for text in (blocks, f"{objects} {left_out}".strip(), ready) if text]


def _sentence(topic: str, subjects: Subjects, describe: Callable[[SubjectResults], str]) -> str:
    """Return a sentence on one topic, with a clause for each dataset that has results on it.

    Return "" if no dataset has results on it.
    """
    texts = {title: text for title, results in subjects.items() if (text := describe(results))}
    several = len(subjects) > 1
    listed = "; ".join(f"{title.lower()} {t}" if several else t for title, t in texts.items())
    return f"{topic}: {listed}." if listed else ""


def _on_blocks(results: SubjectResults) -> str:
    splits = {name: results[BLOCKS][name].split(RANDOM) for name in results[BLOCKS]}
    shares = {n: s.accuracy for n in ACCURACIES if (s := splits.get(n)) and s.accuracy is not None}
    worse = any(share < ACCURACIES[n] - SHARE_TOLERANCE for n, share in shares.items())
    return _compared(shares, ACCURACIES, worse, percent)


def _on_objects(results: SubjectResults) -> str:
    errors = {n: results[OBJECTS][n].rmse for n in ERRORS if n in results[OBJECTS]}
    worse = any(error > (1 + ERROR_TOLERANCE) * ERRORS[n] for n, error in errors.items())
    return _compared(errors, ERRORS, worse, UNITS["one"])


def _compared(
    scores: Mapping[str, float],
    published: Mapping[str, float],
    worse: bool,
    form: Callable[[float], str],
) -> str:
    listed = [
        f"{names.estimator(name).title} {form(score)} against {form(published[name])}"
        for name, score in scores.items()
    ]
    verdict = "worse than" if worse else "as good as"
    return f"{verdict} published ({', '.join(listed)})" if listed else ""


def _left_out(results: SubjectResults) -> str:
    """Return text on the errors for a Shore A that was left out of training.

    It states the errors of the default estimator and of the peak amplitude, and the smallest error.
    """
    splits = {name: scores.split(LEVEL) for name, scores in results[BLOCKS].items()}
    errors = {name: s.rmse for name, s in splits.items() if s and s.rmse is not None}
    if ESTIMATORS.default not in errors:
        return ""
    chosen = dict.fromkeys([ESTIMATORS.default, "peak", min(errors, key=lambda n: errors[n])])
    one = UNITS["one"]
    return ", ".join(f"{names.estimator(n).title} {one(errors[n])}" for n in chosen if n in errors)


def _ready(results: SubjectResults) -> str:
    scores = results[IN_FORCE]
    return "" if scores is None else percent(scores.share)


def subject_title(findings: Findings) -> str:
    """Return the title of a dataset under study, with "(twin)" if its pinches are simulated."""
    return f"{findings.title} (twin)" if is_twin(findings.results) else findings.title


def study_page(state: State) -> Page:
    all_findings = [findings for findings in state.findings if findings.results is not NOTHING]
    subjects = {subject_title(findings): findings.results for findings in all_findings}
    by_title = {findings.title: findings.results for findings in all_findings}
    twin = any(map(is_twin, subjects.values()))
    data = kind(subjects)
    few = "few pinches" if twin else "few folds"
    return Page(
        title=f"First contact: {data.lower()}{' (running)' if state.pending else ''}",
        heading=_TWIN_HEADING if twin else _HEADING,
        intro=_TWIN_INTRO if twin else _INTRO,
        badges=[data, *subjects, state.started, state.elapsed, f"seed {state.settings['seed']}"],
        warning=f"Quick study: {few}, briefly trained networks; do not quote its numbers",
        outcome=outcome(by_title),
        claims=claims(by_title),
        claims_text=f"{_TWIN_CLAIMS if twin else _CLAIMS} {VERDICTS}",
        how=_how(subjects),
        several=len(subjects) > 1,
    )


_TWIN_HEADING = "First contact: stiffness in the first 15 ms"
_HEADING = "First contact: stiffness from the first 15 ms after contact"
_TWIN_INTRO = (
    "Every experiment of “At First Contact” (Pimpalkar, Slepyan, Thakor), repeated on a simulated "
    "hand (the twin). The results follow from the simulation's assumptions: a real hand may differ."
    " “Paper rig” has the paper's conditions; in “everyday”, hand, temperature and objects vary."
)
_INTRO = (
    "The experiments of “At First Contact” (Pimpalkar, Slepyan, Thakor) that the labels of these "
    "recordings permit."
)
_TWIN_CLAIMS = (
    "The published numbers come from one real hand. No parameter of the twin was chosen by a score."
)
_CLAIMS = "The published numbers come from another hand and its objects."


def _how(subjects: Subjects) -> list[tuple[str, list[str]]]:
    estimators = (
        "No training and no search of hyper-parameters uses the test side of a split. Fixed "
        "choices were made on twin sessions of seeds 11 and 77."
    )
    notes = [(title, results[DATA]) for title, results in subjects.items()]
    return [
        ("Estimators", [estimators]),
        ("Data on both sides", list(filter(None, [shared(subjects)]))),
        *((title, list(data.notes)) for title, data in notes if data),
    ]


def shared(subjects: Subjects) -> str:
    """Return sentences on sessions, specimens and Shore A values on both sides of a split."""
    sentences = []
    folds = [results[CONTACT].about.folds for results in subjects.values()]
    if any(subject_results and subject_results.n > 1 for subject_results in folds):
        sentences.append(
            "Folds of contact detection hold out sessions where those are known, and share "
            "specimens."
        )
    if any(is_learned(results) and _leaves_out(results) for results in subjects.values()):
        sentences.append(
            "If a Shore A level or a material is left out, only the estimator was not trained on "
            "it. The detector that places the windows was."
        )
    return " ".join(sentences)


def _leaves_out(results: SubjectResults) -> bool:
    order = results[HARDNESS]
    levels = any(scores.leave_one_shore_out for scores in results[BLOCKS].values())
    return levels or bool(order and order.leave_one_material_out)
