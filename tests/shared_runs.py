"""Folders that all processes of a test run share."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Callable
from pathlib import Path

import pytest

from firstcontact.core import temporary_path


def made_once(factory: pytest.TempPathFactory, name: str, make: Callable[[Path], object]) -> Path:
    """Return a folder of the whole test run; the first process that asks makes it.

    Parameters
    ----------
    factory
        Of temporary folders, from pytest.
    name
        Name of the folder.
    make
        Function that makes the folder at the path given.
    """
    root = factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        root = root.parent  # that of all workers
    folder = root / name
    with (root / f"{name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not folder.exists():
            with temporary_path(folder) as making:
                make(making)
                making.rename(folder)
    return folder
