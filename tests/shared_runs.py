"""Files and folders that all processes of a test run share."""

import fcntl
import os
from collections.abc import Callable
from pathlib import Path

import pytest

from firstcontact.core.files import temporary_path


def made_once(factory: pytest.TempPathFactory, name: str, make: Callable[[Path], object]) -> Path:
    """Return a file or folder of the whole test run. The first process that needs it makes it.

    Parameters
    ----------
    factory
        Factory of temporary folders, from pytest.
    name
        Name of the file or folder.
    make
        Function that makes the file or folder at a given path.
    """
    root = factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        root = root.parent  # that of all workers
    path = root / name
    with (root / f"{name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not path.exists():
            with temporary_path(path) as making:
                make(making)
                making.rename(path)
    return path
