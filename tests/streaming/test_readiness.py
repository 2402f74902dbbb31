"""A real-time session changes settings of the process and restores them."""

from __future__ import annotations

import gc
import os
import sys

from firstcontact.streaming._readiness import Readiness


def settings_now() -> tuple[float, bool, int, int]:
    return sys.getswitchinterval(), gc.isenabled(), gc.get_freeze_count(), os.sched_getscheduler(0)


def test_all_settings_are_as_before_when_it_ends() -> None:
    gc.unfreeze()  # the tests' own frozen objects would not be frozen again
    previous = settings_now()
    with Readiness(real_time=True) as readiness:
        readiness.hurry(is_urgent=True)
        assert not gc.isenabled()
        assert sys.getswitchinterval() < previous[0]
        assert gc.get_freeze_count() > 0
    assert settings_now() == previous


def test_a_collector_that_was_off_stays_off() -> None:
    gc.disable()
    try:
        with Readiness(real_time=True) as readiness:
            readiness.hurry(is_urgent=False)
            assert not gc.isenabled()
        assert not gc.isenabled()
    finally:
        gc.enable()


def test_a_replay_changes_nothing() -> None:
    previous = settings_now()
    with Readiness(real_time=False) as readiness:
        readiness.hurry(is_urgent=True)
        assert settings_now() == previous
