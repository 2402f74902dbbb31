"""The page: one file that needs nothing else."""

from __future__ import annotations

import base64
from pathlib import Path

from firstcontact_lab.grasping.chapters import fronts, pictures, tables
from firstcontact_lab.grasping.results import GraspResults
from firstcontact_lab.grasping.sentences import sentences
from firstcontact_lab.report.page import duration
from firstcontact_lab.report.template import filled


def render(results: GraspResults, film: Path) -> str:
    """Render the report, HTML.

    Parameters
    ----------
    results
        What ``results.json`` holds.
    film
        An animated GIF; goes into the page.
    """
    moving = base64.b64encode(film.read_bytes()).decode()
    return filled(
        "firstcontact_lab.grasping",
        "report.html",
        results=results,
        sentences=sentences(results),
        tables=tables(results),
        pictures=pictures(results),
        film=f"data:image/gif;base64,{moving}",
        opening=fronts(results),
        elapsed=duration(results.study.seconds),
    )
