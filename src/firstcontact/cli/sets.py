"""``firstcontact sets``: the detectors on several real sets, on one page."""

from __future__ import annotations

import shlex
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import tyro

from firstcontact.core.extras import need


@dataclass(frozen=True)
class Sets:
    """Hold the detectors against several real sets, and put what was found of them on one page."""

    folder: tyro.conf.Positional[Path]
    """A folder with one for each set: NAME/recordings; perhaps NAME/noise with recordings in which
    nothing is touched, NAME/results.json of a study, NAME/front_ends.csv (session, front_end)."""
    twin: Path
    """Recordings of the twin to learn from."""

    def run(self) -> None:
        """Score every set, and write report.html and results.json into the folder."""
        need("study", "jinja2")
        from firstcontact.core.files import write_text
        from firstcontact.recording import load_dataset
        from firstcontact.report.folder import REPORT, RESULTS
        from firstcontact.report.results.file import read_results, write_results
        from firstcontact.report.results.sets import SetsResults
        from firstcontact.report.sets_page import in_words, render
        from firstcontact.report.state import versions
        from firstcontact.study.set_folder import find_sets
        from firstcontact.study.sets import score_set

        found = find_sets(self.folder)
        if (self.folder / RESULTS).exists():
            read_results(self.folder / RESULTS, SetsResults)  # nothing else is written over
        twin = load_dataset(self.twin)
        began = time.monotonic()
        scored = {its.name: score_set(its, twin, _say) for its in found}
        results = SetsResults(
            command=shlex.join(["firstcontact", *sys.argv[1:]]),
            seconds=round(time.monotonic() - began, 1),
            versions=versions(),
            sets=scored,
        )
        write_results(self.folder / RESULTS, results)
        write_text(self.folder / REPORT, render(results))
        for line in in_words(results):
            print(line)
        print(self.folder / REPORT)


def _say(line: str) -> None:
    print(line, file=sys.stderr)
