"""The page: one file that needs nothing else."""

from __future__ import annotations

from firstcontact.core import installed_versions
from firstcontact_lab.report import _texts as texts
from firstcontact_lab.report._chapters import chapters, subject_title
from firstcontact_lab.report._headlines import headlines
from firstcontact_lab.report.comparison import compare
from firstcontact_lab.report.results.study import NOTHING
from firstcontact_lab.report.state import State
from firstcontact_lab.report.template import filled


def render(state: State) -> str:
    """Render the report as the study stands, HTML."""
    shown = [f for f in state.findings if f.results is not NOTHING]
    found = [f.results for f in shown]
    names = [subject_title(f) for f in shown]
    twin = any(results.twin for results in found)
    return filled(
        "firstcontact_lab.report",
        "report.html",
        state=state,
        twin=twin,
        shared=texts.shared(found),
        briefly=texts.briefly(found) if state.quick else "",
        kind=texts.kind(found),
        subjects=names,
        headlines=headlines(shown),
        compared=compare(found, names, twin) if found else [],
        sections=chapters(shown),
        notes=[(subject_title(f), f.results.data.notes) for f in shown if f.results.data],
        left_out=[(subject_title(f), f.left_out) for f in shown if f.left_out],
        versions=installed_versions(),
        elapsed=duration(state.seconds),
        parts=[(title, duration(s)) for title, s in state.part_seconds.items()],
    )


def duration(seconds: float) -> str:
    """Seconds as they are read."""
    whole = round(seconds)
    return f"{whole} s" if whole < 90 else f"{whole // 60} min {whole % 60:02d} s"
