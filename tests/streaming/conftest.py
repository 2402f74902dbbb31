"""Detector and models trained on a few twin pinches, shared by the tests of this folder."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import pytest
from page_feed import DESCRIPTOR, LANDMARKS, Requests

from firstcontact.contact import Detector, SvmDetector, detect
from firstcontact.core import Dataset, Label, Pinch
from firstcontact.models import Task, Touches, WindowPredictor, make_estimator
from firstcontact.models.model_file import pretrained
from firstcontact.models.rig.rig_model import RigModel
from firstcontact.models.rig.rigs import Rig
from firstcontact.signal import contact_windows
from firstcontact.streaming.page.sink import PageSink
from firstcontact.twin import BLOCKS, CONDITIONS, draw_pinch, simulate_pinch
from firstcontact.twin.draw import draw_specimen
from page_browser import browsing
from stored_fits import stored

PAPER_RIG = CONDITIONS["paper-rig"]

SEED = 5


def twin_pinches(numbers: Sequence[int]) -> Dataset:
    """Return pinches of the five blocks in turn."""
    pinches: list[Pinch] = []
    for n in numbers:
        kind = BLOCKS[n % len(BLOCKS)]
        session = f"s{n % 4}"
        draw = draw_pinch(SEED, PAPER_RIG, session, draw_specimen(SEED, PAPER_RIG, kind, 0), n)
        label = Label(kind.name, kind.shore_a, session=session, specimen=kind.name)
        pinches.append(simulate_pinch(draw, label, 10_000 * n))
    return Dataset(tuple(pinches), "twin")


@pytest.fixture(scope="session")
def training() -> Dataset:
    return twin_pinches(range(60))


@pytest.fixture(scope="session")
def fresh() -> Dataset:
    """Pinches that are not in the training data."""
    return twin_pinches(range(100, 112))


@pytest.fixture(scope="session")
def detector(training: Dataset) -> Detector:
    return stored(SvmDetector.fit)(SvmDetector(), training)


@pytest.fixture(scope="session")
def models(training: Dataset, detector: Detector) -> list[WindowPredictor]:
    """Models for windows of 3 and 15 ms."""
    out = []
    for duration in (0.003, 0.015):
        contacts = [next(iter(detect(detector, p)), None) for p in training.pinches]
        windows, selected = contact_windows(training, contacts, duration)
        estimator = make_estimator("svm", Task.REGRESSION, training.layout.rate)
        model = estimator.fit(windows, np.asarray(training.shore_a[selected]), seed=0)
        out.append(WindowPredictor(model))
    return out


@pytest.fixture(scope="session")
def anytime(training: Dataset, detector: Detector) -> RigModel:
    """Network of the package, conditioned on the rig of these pinches."""
    contacts = [next(iter(detect(detector, p)), None) for p in training.pinches]
    touches, rows = Touches.cut(training, contacts)
    return pretrained().conditioned_on({Rig.ANY: Rig.fit(touches, training.shore_a[rows])})


@pytest.fixture
def requests() -> Requests:
    return Requests()


@pytest.fixture
def page(requests: Requests) -> Iterator[PageSink]:
    """Page on a free port, whose controls are ``requests``."""
    sink = PageSink(port=0, controls=requests, landmarks=LANDMARKS)
    sink.open(DESCRIPTOR)
    yield sink
    sink.close()


@pytest.fixture(scope="session")
def chromium(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    with browsing(tmp_path_factory.mktemp("profile")) as driver:
        yield driver
