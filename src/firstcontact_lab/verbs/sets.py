"""``firstcontact sets``: the detectors on several real sets, on one page."""

from __future__ import annotations

import shlex
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import tyro

from firstcontact.core import InputError, require_modules

if TYPE_CHECKING:
    from firstcontact.core import Dataset


@dataclass(frozen=True)
class Sets:
    """Hold the detectors against several real sets, and put what was found of them on one page."""

    folder: tyro.conf.Positional[Path]
    """A folder with one for each set: NAME/recordings; perhaps NAME/noise with recordings in which
    nothing is touched, NAME/results.json of a study, NAME/front_ends.csv (session, front_end)."""
    twin: Path
    """Recordings of the twin to learn from."""
    noises: tuple[Path, ...] = ()
    """More folders of the twin's recordings, of the same pinches over different noises (`simulate
    --noise`): a row each, by what learned from --twin."""

    def run(self) -> None:
        """Score every set, and write report.html and results.json into the folder."""
        require_modules("study", "jinja2")
        from firstcontact.core import installed_versions, write_text
        from firstcontact.recording import load_dataset
        from firstcontact_lab.report.folder import REPORT, RESULTS
        from firstcontact_lab.report.results.file import read_results, write_results
        from firstcontact_lab.report.results.sets import SetsResults
        from firstcontact_lab.report.sets_page import in_words, render
        from firstcontact_lab.study.noises import NoiseScorer
        from firstcontact_lab.study.set_folder import find_sets
        from firstcontact_lab.study.sets import score_set

        found = find_sets(self.folder)
        if (self.folder / RESULTS).exists():
            read_results(self.folder / RESULTS, SetsResults)  # nothing else is written over
        twin = load_dataset(self.twin)
        others = [(path.name, load_dataset(path)) for path in self.noises]
        _check_alike(twin, others)
        began = time.monotonic()
        scored = {its.name: score_set(its, twin, _say) for its in found}
        scorer = NoiseScorer(twin, say=_say) if others else None
        results = SetsResults(
            command=shlex.join(["firstcontact", *sys.argv[1:]]),
            seconds=round(time.monotonic() - began, 1),
            versions=installed_versions(),
            sets=scored,
            noises={n: scorer.score(n, its) for n, its in others} if scorer else None,
        )
        write_results(self.folder / RESULTS, results)
        write_text(self.folder / REPORT, render(results))
        for line in in_words(results):
            print(line)
        print(self.folder / REPORT)


def _check_alike(twin: Dataset, others: Sequence[tuple[str, Dataset]]) -> None:
    """Before anything is computed: what is asked about has names, contacts and one layout."""
    names = [name for name, _ in others]
    for name, its in others:
        if names.count(name) > 1:
            raise InputError(f"two folders of --noises are called {name}: rename one")
        if its.layout != twin.layout:
            raise InputError(f"{name} of --noises has another layout than --twin: simulate both")
        if not any(p.first is not None for p in its.pinches):
            raise InputError(f"{name} of --noises has no known contact: simulate it")


def _say(line: str) -> None:
    print(line, file=sys.stderr)
