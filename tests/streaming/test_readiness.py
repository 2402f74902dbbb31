"""A session is ready before its first contact, and leaves nothing behind."""

import gc
import os
import subprocess
import sys
from pathlib import Path

import pytest

import firstcontact as fc
from firstcontact.chain import Chain
from firstcontact.contact import Detector
from firstcontact.core import fingertip_layout
from firstcontact.streaming import Pipeline
from firstcontact.streaming.real_time import real_time_process


def settings_now() -> tuple[float, bool, int, int]:
    return sys.getswitchinterval(), gc.isenabled(), gc.get_freeze_count(), os.sched_getscheduler(0)


def test_all_settings_are_as_before_when_it_ends() -> None:
    gc.unfreeze()  # the tests' own frozen objects would not be frozen again
    previous = settings_now()
    granted: list[str] = []
    with real_time_process(real_time=True, notify=granted.append) as hurry:
        hurry(True)
        has_priority = os.sched_getscheduler(0) != previous[3]
        locked = "VmLck:\t       0 kB" not in Path("/proc/self/status").read_text("ascii")
        words = ["granted" if x else "not granted" for x in (has_priority, locked)]
        assert granted == [f"system: real-time scheduling {words[0]}, locked memory {words[1]}"]
        assert not gc.isenabled()
        assert sys.getswitchinterval() < previous[0]
        assert gc.get_freeze_count() > 0
    assert settings_now() == previous
    assert "VmLck:\t       0 kB" in Path("/proc/self/status").read_text("ascii")


def test_a_replay_changes_nothing() -> None:
    previous = settings_now()
    with real_time_process(real_time=False) as hurry:
        hurry(True)
        assert settings_now() == previous


SESSION = """
import sys, time
import firstcontact as fc
from firstcontact.grasp import HANDS
from firstcontact.models.model import shipped_model
from firstcontact.streaming.hand_plan import HandPlan
from firstcontact.streaming.live_session import SessionPlan, live_session

def positions(hand):
    now = time.monotonic()
    return [(now - k / 200, -k * 0.1 / 200) for k in range(200)]

HANDS["print"].positions = positions
source = fc.open("twin", seed=1)
plan = SessionPlan(model=shipped_model(), hand=HandPlan("print"))
with live_session(source, plan, opens=True) as session:
    loaded = set(sys.modules)
    (done,) = [e for e in session.events(pinches=1) if isinstance(e, fc.PinchDone)]
    print(*sorted(set(sys.modules) - loaded))
assert done.closing_speed is not None and done.estimates
"""


def test_a_session_whose_hand_reports_positions_imports_nothing() -> None:
    """A new process, since the test's own has imported almost everything."""
    program = subprocess.run([sys.executable, "-c", SESSION], capture_output=True, text=True)
    assert program.returncode == 0, program.stderr
    assert program.stdout.split() == []


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
