"""Sets of real recordings in folders: recordings, noise, and results of a study."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from firstcontact.core import Block, Dataset, InputError, Layout
from firstcontact.recording import find_recordings, load_dataset, read_recording, read_rows
from firstcontact_lab.report.results import SubjectResults
from firstcontact_lab.study.page import read_study
from firstcontact_lab.study.parts.contacts import CONTACT

RECORDINGS, NOISE, FRONT_ENDS, RESULTS = "recordings", "noise", "front_ends.csv", "results.json"


@dataclass(frozen=True, slots=True, eq=False)
class RealSet:
    """Set of real recordings in a folder."""

    name: str
    dataset: Dataset
    noise: tuple[Block, ...]
    front_ends: dict[str, str]
    study: SubjectResults | None
    early: float

    def front_end(self, session: str) -> str:
        """Return the description of a session's front end; "" if unknown."""
        return self.front_ends.get(session, self.front_ends.get("*", ""))

    @property
    def layout(self) -> Layout:
        """Layout of the set's pinches."""
        return self.dataset.layout


def find_sets(folder: Path) -> list[RealSet]:
    """Return the sets in a folder, which are its subfolders with recordings."""
    if not folder.is_dir():
        raise InputError(
            f"{folder} is not a folder: give the folder that has a subfolder for each set"
        )
    places = sorted(p for p in folder.iterdir() if (p / RECORDINGS).is_dir())
    if not places:
        raise InputError(
            f"{folder} contains no set: import recordings into {folder / 'NAME' / RECORDINGS}"
        )
    return [_read(place) for place in places]


def _read(place: Path) -> RealSet:
    noise: list[Block] = []
    dataset = load_dataset(place / RECORDINGS)
    if (place / NOISE).is_dir():
        for file in find_recordings(place / NOISE):
            recording = read_recording(file)
            if recording.header.layout != dataset.layout:
                raise InputError(
                    f"{file}: its layout differs from that of the set's recordings: import both "
                    "in the same way"
                )
            noise += recording.stretches
    ends = {}
    if (place / FRONT_ENDS).exists():
        rows = read_rows(place / FRONT_ENDS, ["session", "front_end"])
        ends = {row["session"]: row["front_end"] for _, row in rows}
    study, early = None, 0.0
    if (place / RESULTS).exists():
        results = read_study(place / RESULTS)
        study = results.about
        early = 1e-3 * (study[CONTACT].about.early_ms or 0.0)
    return RealSet(place.name, dataset, tuple(noise), ends, study, early)
