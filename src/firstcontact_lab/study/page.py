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
    Cell,
    Line,
    Row,
    Table,
    beside,
    claims_table,
    row_table,
)
from firstcontact_lab.study.part import Part, Subjects
from firstcontact_lab.study.parts import PARTS
from firstcontact_lab.study.parts.blocks import BLOCKS
from firstcontact_lab.study.parts.contacts import CONTACT, is_learned
from firstcontact_lab.study.parts.data import DATA, is_twin, kind
from firstcontact_lab.study.parts.hardness import HARDNESS
from firstcontact_lab.study.parts.objects import OBJECTS


def read_study(path: Path) -> StudyResults:
    """Read the ``results.json`` of a study.

    Raises
    ------
    InputError
        A field is missing, unknown, or of another type.
    """
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


def comparison(subjects: Subjects) -> Table:
    """Return a table of published and measured numbers, with remarks."""
    compared = {row.label: row for row in rows(subjects) if row.remark is not None}
    table = row_table(compared.values(), subjects, published=True)
    lines = [
        Line([*line.cells, Cell(compared[line.cells[0].text].remark_on(subjects))])
        for line in table.lines
    ]
    return Table("", [*table.head, "remark"], lines)


def claims(subjects: Subjects) -> Table:
    """Return a table of the paper's claims with verdicts, then of further main results."""
    chosen = sorted(rows(subjects), key=lambda row: row.claim is None)
    return claims_table(chosen, subjects)


def sections(all_findings: Sequence[Findings], parts: Mapping[str, Part] = PARTS) -> list[Section]:
    """Return the sections of these parts that have content."""
    subjects = {findings.title: findings.results for findings in all_findings}
    made = (_section(name, part, subjects, all_findings) for name, part in parts.items())
    return [section for section in made if section is not None]


def _section(
    name: str, part: Part, subjects: Subjects, all_findings: Sequence[Findings]
) -> Section | None:
    """Return a section of the report; None if it has no content.

    One figure and one table show all subjects. Further figures and tables are hidden until opened.
    """
    tables: dict[str, list[Table]] = {}
    figures: dict[str, list[Figure]] = {}
    for findings in all_findings:
        made = (make(findings.results) for make in part.tables)
        tables[findings.title] = [table for table in made if table]
        figures[findings.title] = list(findings.figures.get(name, {}).values())
    if not any(tables.values()) and not any(figures.values()):
        return None
    drawn = part.figure(subjects)
    lead = (
        [drawn] if drawn else [_titled(title, each[0]) for title, each in figures.items() if each]
    )
    first = {title: each[0] for title, each in tables.items() if each}
    details = [
        Column(
            title,
            tables[title][1:],
            figures[title] if drawn else figures[title][1:],
        )
        for title in tables
    ]
    return Section(
        part.name,
        part.title,
        part.text(subjects),
        figures=lead,
        table=beside(first, part.columns) if first else None,
        details=[column for column in details if column.tables or column.figures],
    )


def _titled(title: str, figure: Figure) -> Figure:
    """Return a figure with the name of its subject in the title."""
    return replace(figure, title=f"{figure.title}, {title}")


def subject_title(findings: Findings) -> str:
    """Return the title of a subject, with "(twin)" after it if its pinches are simulated."""
    return f"{findings.title} (twin)" if is_twin(findings.results) else findings.title


def render(state: State) -> str:
    """Return the report of a study so far, HTML."""
    all_findings = [findings for findings in state.findings if findings.results is not NOTHING]
    subjects = {subject_title(findings): findings.results for findings in all_findings}
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
        claims=claims({findings.title: findings.results for findings in all_findings}),
        terms=_TERMS,
        compared=comparison(subjects),
        compared_text=f"{_TWIN_COMPARED if twin else _COMPARED} {VERDICTS}",
        sections=sections(all_findings),
        left_out=[(subject_title(f), f.left_out) for f in all_findings if f.left_out],
        command=state.command,
        how=_how(state, subjects, twin),
        versions=installed_versions(),
        times=[(title, duration(seconds)) for title, seconds in state.part_seconds.items()],
        several=len(subjects) > 1,
    ).html()


_TERMS = [
    (
        "Baseline",
        "a prediction that ignores the shape of the signal: the training mean, the most "
        "frequent class, or the peak amplitude alone",
    ),
    ("Chance", "the accuracy of the best constant prediction"),
    ("Interval", "95 % bootstrap interval over sessions or objects, in small numbers or as a bar"),
]
_TWIN_HEADING = "First contact: stiffness in the first 15 ms"
_HEADING = "First contact: stiffness from the first 15 ms after contact"
_TWIN_INTRO = (
    "Every experiment of “At First Contact” (Pimpalkar, Slepyan, Thakor), repeated on pinches of "
    "a simulated hand (the twin). The results show what the method does under the assumptions of "
    "the simulation, not what a real hand reaches."
)
_INTRO = (
    "The experiments of “At First Contact” (Pimpalkar, Slepyan, Thakor) that the labels of these "
    "recordings permit."
)
_TWIN_COMPARED = (
    "The published numbers come from one real hand; those here from its twin. Read them side by "
    "side: no parameter of the twin was set by a score."
)
_COMPARED = "The published numbers come from another hand and its objects."


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


def _how(state: State, subjects: Subjects, twin: bool) -> list[tuple[str, list[str]]]:
    scope = "" if twin else ", not on these recordings"
    estimators = (
        "Hyper-parameters are searched inside the training side of each split: no training and no "
        "search uses the test side. Fixed choices (gamma, cost and youngest contact of "
        "the SVM detector, the form of the stiffness SVM's input, the size of the network) were "
        f"made beforehand on twin sessions of seeds 11 and 77{scope}."
    )
    brief = _briefly(subjects) if state.quick else ""
    notes = [(title, results[DATA]) for title, results in subjects.items()]
    return [
        ("Seed", [f"{state.settings['seed']} (twin, splits, searches, networks and intervals)"]),
        ("Workers", [f"{state.settings['workers']}, one thread each"]),
        ("Time", [elapsed(state)]),
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
