"""Memory of live sessions: nothing of a session is left after it."""

import gc
import sys

import pytest

import firstcontact as fc
from firstcontact.chain import Chain
from firstcontact.contact import Detector
from firstcontact.core import fingertip_layout
from firstcontact.streaming import Pipeline


def chains() -> int:
    """Return the number of chains that are in memory."""
    gc.collect()
    return sum(issubclass(type(thing), Chain) for thing in gc.get_objects())


@pytest.mark.parametrize("events", [1, sys.maxsize])
def test_no_session_stays_in_memory(events: int) -> None:
    before = chains()
    for _ in range(3):
        with fc.open("twin", speed=100) as source:
            session = fc.live(source, seconds=3)
            assert [event for _, event in zip(range(events), session, strict=False)]
            session.close()
        del session, source
    assert chains() == before


def test_no_pipeline_with_a_detector_in_python_stays_in_memory(detector: Detector) -> None:
    before = chains()
    pipeline = Pipeline(fingertip_layout(), detector)
    assert chains() == before + 1
    del pipeline
    assert chains() == before
