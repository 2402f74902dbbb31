"""Fixtures shared by all tests."""

import gc
import os

# Tests run side by side, one a core: threads of theirs only wait for one another. Libraries look
# when they are imported, processes that a test starts inherit it.
for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import signal
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from hypothesis import settings

import stored_fits
from firstcontact.core import Dataset
from forked_children import fork_children
from quick_training import SETTINGS
from shared_runs import made_once
from toy_pinches import rank_dataset, shore_dataset

# Tests assert no times: neither here nor by the way.
settings.register_profile("firstcontact", deadline=None, max_examples=50)
settings.load_profile("firstcontact")

# Some hundred tests have a twin on a port, or read files of other libraries.
fork_children()

# Figures are drawn to files; no test needs a display.
os.environ["MPLBACKEND"] = "Agg"

# A shell that runs the tests in the background has Ctrl-C ignored, and every process that a
# test starts would inherit that and never be interrupted.
signal.signal(signal.SIGINT, signal.default_int_handler)
# The same for nohup and a hang-up, and for SIGQUIT.
signal.signal(signal.SIGHUP, signal.SIG_DFL)
signal.signal(signal.SIGQUIT, signal.SIG_DFL)


#: Part of the name of the longest test, which waits for a hand in real time.
LONGEST = "test_tutorials_run_in_a_row"
#: Parts of the names of tests that load PyTorch, and a fixture that does.
TORCH = ("cnn", "pretrain", "test_anytime_network", "test_protocol")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put the longest test first, and then those that load PyTorch, which takes 2 s or more.

    Each process gets a contiguous part of the tests, so one process runs nearly all of these.
    """
    items.sort(key=lambda item: (LONGEST not in item.nodeid, not loads_torch(item)))


def loads_torch(item: pytest.Item) -> bool:
    """Return True if a test loads PyTorch."""
    return any(part in item.nodeid for part in TORCH)


def pytest_collection_finish() -> None:
    """Exempt the collected tests from garbage collection, which would take longer for each."""
    gc.collect()
    gc.freeze()


@pytest.fixture(scope="session")
def impacts() -> Path:
    """Folder of real impacts: ``FIRSTCONTACT_DATA``, or a copy next to the checkout."""
    for folder in (_real(), _real() / "impact_hardness"):
        if (folder / "labels.csv").is_file():
            return folder
    pytest.skip("no real impacts: set FIRSTCONTACT_DATA, see docs/reference/results.md")


@pytest.fixture(scope="session")
def strikes() -> Path:
    """Folder of real strikes on piezo discs, located like the impacts."""
    for folder in (_real(), _real() / "piezo_strikes"):
        if (folder / "hits.csv").is_file():
            return folder
    pytest.skip("no real strikes: set FIRSTCONTACT_DATA")


@pytest.fixture(scope="session")
def biotac() -> Path:
    """Folder of real BioTac recordings in MATLAB files, located like the impacts."""
    for folder in (_real(), _real() / "biotac_hold" / "data"):
        if any(folder.glob("*_HOLD.mat")):
            return folder
    pytest.skip("no real BioTac recordings: set FIRSTCONTACT_DATA")


def _real() -> Path:
    beside = Path(__file__).parents[2] / "shared" / "data"
    return Path(os.environ.get("FIRSTCONTACT_DATA") or beside).resolve()


@pytest.fixture(scope="session")
def shore() -> Dataset:
    """Synthetic pinches with Shore A."""
    return shore_dataset()


@pytest.fixture(scope="session")
def ranks() -> Dataset:
    """Synthetic pinches with ranks of hardness."""
    return rank_dataset()


@pytest.fixture(scope="session")
def make_shore() -> Callable[..., Dataset]:
    """Factory of synthetic pinches with Shore A."""
    return shore_dataset


@pytest.fixture(scope="session", autouse=True)
def _shared_objects(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Compile equal C files of `firmware/measure`, and fit equal detectors, once in a test run."""
    with pytest.MonkeyPatch.context() as patch:
        for variable in ("FIRSTCONTACT_OBJECTS", stored_fits.FOLDER):
            patch.setenv(variable, str(made_once(tmp_path_factory, variable, Path.mkdir)))
        yield


@pytest.fixture(scope="session")
def user_cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a user's cache, empty at first."""
    return tmp_path_factory.mktemp("cache")


@pytest.fixture(scope="module")
def small_searches() -> Iterator[None]:
    """Search few hyperparameters, and train detectors on few pinches."""
    with pytest.MonkeyPatch.context() as patch:
        for name, value in SETTINGS.items():
            patch.setattr(name, value)
        yield


@pytest.fixture(scope="module")
def stored_detectors() -> Iterator[None]:
    """Fit equal detectors once in a test run, with the shipped values."""
    with pytest.MonkeyPatch.context() as patch:
        for name, fit in stored_fits.FITS.items():
            patch.setattr(name, fit)
        yield
