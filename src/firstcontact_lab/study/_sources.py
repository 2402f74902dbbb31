"""Sources of a study's pinches: the twin, recordings, or data to import."""

from __future__ import annotations

import shutil
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

from firstcontact.core import FINGERTIP_RATE, Dataset, InputError, Runner, files_below
from firstcontact.recording import find_importer, load_dataset
from firstcontact.signal import resample_dataset
from firstcontact_lab.report.folder import MARK, check_fresh, fresh
from firstcontact_lab.study.settings import StudySettings

#: The twin's conditions, in the order of the report.
CONDITIONS = ("paper-rig", "everyday")
#: Files by which a folder can be imported.
LABELS = "labels.csv"
#: Folders inside a study's folder.
_RECORDINGS, _IMPORTED = "recordings", "imported"


def simulated(condition: str, settings: StudySettings, out: Path, runner: Runner) -> Dataset:
    """Simulate pinches of a condition into ``out/recordings``, and return them as a dataset."""
    from firstcontact.twin import simulate

    directory = fresh(out / _RECORDINGS / condition, {"twin": condition, "seed": settings.seed})
    simulate(
        directory / "pinches",
        condition,
        settings.block_pinches,
        settings.object_pinches,
        settings.seed,
        runner=runner,
    )
    return load_dataset(directory)


def recorded(path: Path, out: Path) -> Dataset:
    """Return the pinches of recordings, or of data to import, resampled to the models' rate."""
    recordings = _recordings(path)
    dataset = load_dataset(recordings) if recordings else _imported(path, out)
    return resample_dataset(dataset, FINGERTIP_RATE)


def check_sources(path: Path | None, out: Path) -> None:
    """Raise an InputError if a source cannot be used. If ``path`` is None, it is the twin."""
    if path is None:
        for condition in CONDITIONS:
            check_fresh(out / _RECORDINGS / condition)
    elif not _recordings(path):
        find_importer(path)
        check_fresh(out / _RECORDINGS / _IMPORTED)


def _recordings(path: Path) -> list[Path]:
    """Return the recordings to study, or an empty list if ``path`` holds data to import."""
    if not path.exists():
        raise InputError(f"{path} does not exist: give a folder of recordings, or data to import")
    recordings, made = _search(path)
    if made and (recordings or not (path / LABELS).is_file()):
        content = "recordings, and further ones" if recordings else "only recordings"
        raise InputError(
            f"{path} holds {content} that an earlier study made in {made[0]}: name the one folder "
            "to study"
        )
    return recordings


def _search(path: Path) -> tuple[list[Path], list[Path]]:
    """Return the recordings at a path, and the folders below it with a study's recordings."""
    if path.is_file():
        return [path] if path.suffix == ".mcap" else [], []
    made = sorted(mark.parent for mark in path.rglob(MARK) if mark.parent != path)
    files = files_below(path, ".mcap")
    return [f for f in files if not any(f.is_relative_to(m) for m in made)], made


def _imported(path: Path, out: Path) -> Dataset:
    from firstcontact.recording import import_path

    directory = fresh(out / _RECORDINGS / _IMPORTED, {"imported": path.name})
    try:
        assumed = import_path(path, directory / "pinches").notes
    except InputError:
        shutil.rmtree(directory)
        with suppress(OSError):  # a folder with other recordings stays
            directory.parent.rmdir()
        raise
    dataset = load_dataset(directory)
    return replace(dataset, notes=(*assumed, *dataset.notes))
