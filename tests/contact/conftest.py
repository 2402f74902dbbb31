"""Fitted detectors and a pinch with a click, shared by the tests of this folder."""

import pytest
from clicks import make_pinch

from firstcontact.contact import DETECTORS, make_detector
from firstcontact.testing import closings


@pytest.fixture(scope="session")
def training():
    return closings(40, seed=1)


@pytest.fixture(scope="session")
def fitted(training):
    return {name: make_detector(name).fit(training) for name in DETECTORS}


@pytest.fixture(params=sorted(DETECTORS))
def detector(request, fitted):
    return fitted[request.param]


@pytest.fixture(scope="session")
def clicked():
    return make_pinch(3, click=True)
