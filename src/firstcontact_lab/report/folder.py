"""Folder of a study: locked while it runs, and never overwritten by another study."""

from __future__ import annotations

import fcntl
import json
import os
import shutil
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from firstcontact.core import InputError, write_json
from firstcontact_lab.report.results import read_options

#: Marker file for recordings that a study made and may replace.
MARK = "made-by-study.json"
RESULTS, REPORT = "results.json", "report.html"
_REMEDY = "choose another --out, or move it away"


@contextmanager
def sole_use(out: Path, options: Mapping[str, Any] | None = None) -> Iterator[None]:
    """Make and lock the folder of a study. The lock ends with the ``with`` statement."""
    made = not out.exists()
    try:
        out.mkdir(parents=True, exist_ok=True)
        handle = os.open(out, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    except OSError as error:
        raise InputError(f"{out} cannot be made ({error.strerror}): choose another --out") from None
    try:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise InputError(
                f"{out}: another study is running in this folder: wait until it ends, or choose "
                "another --out"
            ) from None
        except OSError:
            pass  # a disk without locks
        if options is not None:
            _claim(out, options)
        yield
    except InputError:
        if made:
            with suppress(OSError):  # a folder with files in it stays
                out.rmdir()
        raise
    finally:
        os.close(handle)


@contextmanager
def without_worker_warnings() -> Iterator[None]:
    """Hide warnings about worker processes that ended early. Other workers take their jobs."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "A worker stopped while some jobs", UserWarning)
        yield


def _claim(out: Path, options: Mapping[str, Any]) -> None:
    """Raise an InputError if the folder has results that were made with other settings."""
    results = out / RESULTS
    if not results.exists():
        if (out / REPORT).exists():
            raise InputError(f"{out / REPORT} was not made by a study: {_REMEDY}")
        return
    try:
        existing = read_options(results, _REMEDY)
    except (InputError, OSError):
        raise InputError(f"{results} was not made by a study of this version: {_REMEDY}") from None
    mine = json.loads(json.dumps(options))
    if existing != mine:
        differs = sorted(k for k in {*existing, *mine} if existing.get(k) != mine.get(k))
        raise InputError(
            f"{out} holds the results of another study (other {', '.join(differs)}): choose "
            "another --out, or remove it"
        )


def fresh(directory: Path, mark: Mapping[str, object]) -> Path:
    """Return an empty folder with a mark file. Remove the outputs of an earlier study."""
    check_fresh(directory)
    if directory.exists():
        shutil.rmtree(directory)
    write_json(directory / MARK, mark)
    return directory


def check_fresh(directory: Path) -> None:
    """Raise an InputError if the folder exists and was not made by :func:`fresh`."""
    if directory.exists() and not (directory / MARK).exists():
        raise InputError(f"{directory} was not made by a study: {_REMEDY}")
