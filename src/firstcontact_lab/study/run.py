"""Run of a whole study: its datasets, the order of its jobs, and its files."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path

from firstcontact.collect.importing import find_importer, import_recordings
from firstcontact.core import Dataset, FileError, InputError
from firstcontact.core.files import files_below
from firstcontact.core.layout import FINGERTIP_RATE
from firstcontact.jobs import Runner
from firstcontact.recording import load_dataset
from firstcontact.signal import resample_dataset
from firstcontact.twin.simulation import simulate_recordings
from firstcontact_lab.report.findings import PartResult
from firstcontact_lab.report.page import State
from firstcontact_lab.report.run import (
    MARK,
    Job,
    check_marked_folder,
    empty_marked_folder,
    run_steps,
)
from firstcontact_lab.study.page import study_page
from firstcontact_lab.study.part import Step, StudySettings, Subject
from firstcontact_lab.study.parts import PARTS, chosen_parts

#: The twin's conditions, in the order of the report.
CONDITIONS = ("paper-rig", "everyday")
#: File by which a folder can be imported.
LABELS = "labels.csv"
_RECORDINGS, _IMPORTED = "recordings", "imported"

Sources = Sequence[tuple[str, Callable[[], Dataset]]]


def run_study(settings: StudySettings, out: Path, recordings: Path | None, quick: bool) -> Path:
    data = None if recordings is None else str(recordings.resolve())
    sizes = {name: value for name, value in asdict(settings).items() if name != "workers"}
    state = State(
        settings=asdict(settings),
        options={"verb": "study", "recordings": data, **sizes},
        parts=PARTS,
        page=study_page,
        quick=quick,
    )

    def jobs(runner: Runner) -> list[Job]:
        sources: Sources = [
            (name, partial(simulated, name, settings, out, runner)) for name in CONDITIONS
        ]
        if recordings is not None:
            sources = [("recordings", partial(recorded, recordings, out))]
        return plan(sources, settings, runner, _set_name(recordings))

    return run_steps(out, state, settings.workers, jobs, partial(check_sources, recordings, out))


def plan(
    sources: Sequence[tuple[str, Callable[[], Dataset]]],
    settings: StudySettings,
    runner: Runner,
    set_name: str = "recordings",
) -> list[Job]:
    """Return all jobs of a study: first the quick jobs of every dataset, then the slow ones."""
    subjects: dict[str, Subject] = {}

    def job(name: str, load: Callable[[], Dataset], part: str, step: Step) -> Job:
        def measure() -> PartResult:
            if name not in subjects:
                subjects[name] = Subject(name, load(), set_name=set_name)
            return step.run(subjects[name], settings, runner)

        return Job(name, part, step.title, measure, step.vital, step.cost)

    return [
        job(name, load, part, step)
        for late in (False, True)
        for name, load in sources
        for part, entry in chosen_parts(settings.parts).items()
        for step in entry.steps
        if step.late == late
    ]


def _set_name(recordings: Path | None) -> str:
    """Return the name of the recordings in results: the name of their folder or file."""
    name = "" if recordings is None else recordings.resolve().stem
    return name.encode("utf-8", "replace").decode() or "recordings"


def simulated(condition: str, settings: StudySettings, out: Path, runner: Runner) -> Dataset:
    directory = empty_marked_folder(
        out / _RECORDINGS / condition, {"twin": condition, "seed": settings.seed}
    )
    simulate_recordings(
        directory / "pinches",
        condition,
        settings.block_pinches,
        settings.object_pinches,
        settings.seed,
        runner=runner,
    )
    return load_dataset(directory)


def recorded(path: Path, out: Path) -> Dataset:
    recordings = _recordings(path)
    dataset = load_dataset(recordings) if recordings else _imported(path, out)
    return resample_dataset(dataset, FINGERTIP_RATE)


def check_sources(path: Path | None, out: Path) -> None:
    """Raise InputError if the data at ``path`` cannot be studied.

    No ``path`` means a study of the twin.
    """
    if path is None:
        for condition in CONDITIONS:
            check_marked_folder(out / _RECORDINGS / condition)
    elif not _recordings(path):
        find_importer(path)
        check_marked_folder(out / _RECORDINGS / _IMPORTED)


def _recordings(path: Path) -> list[Path]:
    """Return the recordings at ``path``, or an empty list if it holds data to import first."""
    if not path.exists():
        raise FileError(f"{path} does not exist: give a folder of recordings, or data to import")
    recordings, made = _search(path)
    if made and (recordings or not (path / LABELS).is_file()):
        content = "recordings, and further ones" if recordings else "only recordings"
        raise FileError(
            f"{path} holds {content} that an earlier study made in {made[0]}: name the one folder "
            "to study"
        )
    return recordings


def _search(path: Path) -> tuple[list[Path], list[Path]]:
    """Return (recordings at ``path``, folders below it that earlier studies made)."""
    if path.is_file():
        return [path] if path.suffix == ".mcap" else [], []
    made = sorted(mark.parent for mark in path.rglob(MARK) if mark.parent != path)
    files = files_below(path, ".mcap")
    return [f for f in files if not any(f.is_relative_to(m) for m in made)], made


def _imported(path: Path, out: Path) -> Dataset:
    directory = empty_marked_folder(out / _RECORDINGS / _IMPORTED, {"imported": path.name})
    try:
        assumed = import_recordings(path, directory / "pinches").notes
    except InputError:
        shutil.rmtree(directory)
        with suppress(OSError):  # a folder with other recordings stays
            directory.parent.rmdir()
        raise
    dataset = load_dataset(directory)
    return replace(dataset, notes=(*assumed, *dataset.notes))
