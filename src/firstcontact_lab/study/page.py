"""Report of a study: one HTML file that needs no other file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from firstcontact.core import ByName, InputError, installed_versions
from firstcontact.models import window_estimators
from firstcontact_lab.report.findings import Figure, Findings
from firstcontact_lab.report.page import Column, Page, Section
from firstcontact_lab.report.results import NOTHING, SubjectResults, read_results, subject_kind
from firstcontact_lab.report.state import STUDY, State, StudyResults, duration
from firstcontact_lab.report.tables import (
    VERDICTS,
    Row,
    Table,
    beside,
    claims_table,
)
from firstcontact_lab.study.outcome import outcome
from firstcontact_lab.study.part import Part, Subjects
from firstcontact_lab.study.parts import PARTS
from firstcontact_lab.study.parts.blocks import BLOCKS
from firstcontact_lab.study.parts.contacts import CONTACT, is_learned
from firstcontact_lab.study.parts.data import DATA, is_twin, kind
from firstcontact_lab.study.parts.hardness import HARDNESS
from firstcontact_lab.study.parts.objects import OBJECTS


def read_study(path: Path) -> StudyResults:
    """Read the ``results.json`` of a study."""
    list(PARTS.values())  # loading a part defines its fields
    subject = subject_kind()
    kind: Any = ByName
    results: StudyResults = read_results(path, kind[subject, subject])
    if results.about[STUDY] is None:
        raise InputError(f"{path}: the field 'study' is missing: give the results.json of a study")
    return results


def rows(subjects: Subjects, parts: Sequence[str] = ()) -> list[Row[SubjectResults]]:
    """Return the row definitions of these parts; by default of all parts."""
    return [row for name in parts or PARTS for row in PARTS[name].rows(subjects)]


def claims(subjects: Subjects) -> Table:
    """Return a table of the paper's claims with verdicts, then of further main results."""
    chosen = sorted(rows(subjects), key=lambda row: not (row.claim or row.note))
    return claims_table(chosen, subjects)


def sections(all_findings: Sequence[Findings], parts: Mapping[str, Part] = PARTS) -> list[Section]:
    """Return the sections of these parts that have content."""
    subjects = {findings.title: findings.results for findings in all_findings}
    made = (_section(name, part, subjects, all_findings) for name, part in parts.items())
    return [section for section in made if section is not None]


def _section(
    name: str, part: Part, subjects: Subjects, all_findings: Sequence[Findings]
) -> Section | None:
    """Return a section of the report; None if it has no content."""
    tables: dict[str, list[Table]] = {}
    figures: dict[str, list[Figure]] = {}
    for findings in all_findings:
        tables[findings.title] = part.made_tables(findings.results)
        figures[findings.title] = list(findings.figures.get(name, {}).values())
    if not any(tables.values()) and not any(figures.values()):
        return None
    drawn = list(part.figures(subjects))
    open_count = 0 if drawn else 1
    lead = [
        replace(figure, title=f"{figure.title}, {title}")
        for title, each in figures.items()
        for figure in each[:open_count]
    ]
    first = {title: each[0] for title, each in tables.items() if each[:open_count]}
    details = [
        Column(title, tables[title][open_count:], figures[title][open_count:]) for title in tables
    ]
    return Section(
        part.name,
        part.title,
        part.text(subjects),
        figures=drawn or lead,
        table=beside(first, part.columns) if first else None,
        details=[column for column in details if column.tables or column.figures],
    )


def subject_title(findings: Findings) -> str:
    """Return the title of a subject, with "(twin)" after it if its pinches are simulated."""
    return f"{findings.title} (twin)" if is_twin(findings.results) else findings.title


def render(state: State) -> str:
    """Return the report of a study so far, HTML."""
    all_findings = [findings for findings in state.findings if findings.results is not NOTHING]
    subjects = {subject_title(findings): findings.results for findings in all_findings}
    by_title = {findings.title: findings.results for findings in all_findings}
    twin = any(map(is_twin, subjects.values()))
    data = kind(subjects)
    few = "few pinches" if twin else "few folds"
    quick = f"Quick study: {few}, briefly trained networks; do not quote its numbers"
    return Page(
        title=f"First contact: {data.lower()}{' (running)' if state.pending else ''}",
        heading=_TWIN_HEADING if twin else _HEADING,
        intro=_TWIN_INTRO if twin else _INTRO,
        badges=[data, *subjects, state.started, elapsed(state), f"seed {state.settings['seed']}"],
        warning=quick if state.quick else "",
        notice=notice(state),
        outcome=outcome(by_title),
        claims=claims(by_title),
        claims_text=f"{_TWIN_CLAIMS if twin else _CLAIMS} {VERDICTS}",
        sections=sections(all_findings),
        left_out=[(subject_title(f), f.left_out) for f in all_findings if f.left_out],
        command=state.command,
        how=_how(state, subjects),
        versions=installed_versions(),
        several=len(subjects) > 1,
    ).html()


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


def elapsed(state: State) -> str:
    """Return the time that a study has taken, as text."""
    return duration(state.seconds) + (" so far" if state.pending else "")


def notice(state: State) -> tuple[str, str] | None:
    """Return state and details of an unfinished study as text; None if it is finished."""
    if not state.pending:
        return None
    pending = "; ".join(state.pending)
    progress = f"{state.completed} of {len(state.steps)} parts are done."
    if state.stopped or state.interrupted:
        why = f"Stopped: {state.stopped}." if state.stopped else "Interrupted."
        return why, f"{progress} Not done: {pending}."
    return "Still running.", f"{progress} Not done yet: {pending}. Load the page again for more."


def _how(state: State, subjects: Subjects) -> list[tuple[str, list[str]]]:
    estimators = (
        "No training and no search of hyper-parameters uses the test side of a split. Fixed "
        "choices were made on twin sessions of seeds 11 and 77."
    )
    brief = _briefly(subjects) if state.quick else ""
    notes = [(title, results[DATA]) for title, results in subjects.items()]
    return [
        ("Estimators", [estimators + brief]),
        ("Data on both sides", list(filter(None, [shared(subjects)]))),
        *((title, list(data.notes)) for title, data in notes if data),
    ]


def shared(subjects: Subjects) -> str:
    """Return sentences about sessions, specimens and levels on both sides of a split."""
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


def _briefly(subjects: Subjects) -> str:
    """Return a sentence on how estimators were trained in a quick study."""
    used = {name for results in subjects.values() for name in (*results[BLOCKS], *results[OBJECTS])}
    options = [
        f"{entry.title} ({', '.join(f'{key} {value}' for key, value in entry.quick.items())})"
        for name, entry in window_estimators().items()
        if name in used and entry.quick
    ]
    return f" Briefly trained: {', '.join(options)}." if options else ""
