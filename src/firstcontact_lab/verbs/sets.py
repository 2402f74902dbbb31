"""``firstcontact sets``: score contact detectors on several sets of real recordings."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from firstcontact.cli import Option
from firstcontact.core.installation import require_modules


@dataclass(frozen=True)
class Sets:
    """Score contact detectors on several sets of real recordings, and write one report page.

    A set is a folder of recordings. It may also have noise/ (recordings without touches),
    results.json of a study, and front_ends.csv, a table with the columns session and front_end. A
    front end is a sensor with its recording device.
    """

    folder: Annotated[Path, Option(positional=True)]
    """Folder with a subfolder NAME/recordings for each set."""
    twin: Path
    """Recordings of the twin to train on."""
    noises: tuple[Path, ...] = ()
    """Folders of the same twin pinches, each with noise of another sensor."""

    def run(self) -> None:
        require_modules("study", "jinja2")
        from firstcontact.recording import load_dataset
        from firstcontact_lab.report.tables import plain_lines
        from firstcontact_lab.study.set_scores import find_sets
        from firstcontact_lab.study.sets import overview, run_sets

        sets = find_sets(self.folder)
        twin = load_dataset(self.twin)
        noises = [(path.name, load_dataset(path)) for path in self.noises]
        subjects = run_sets(self.folder, sets, twin, noises)
        for line in plain_lines(overview(subjects)):
            print(line)
        print(self.folder / "report.html")
