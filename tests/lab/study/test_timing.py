"""Times exclude calls that another program interrupted."""

from __future__ import annotations

import os
import subprocess
import sys

import numpy as np
import pytest

from firstcontact_lab.study.timing import Timed, load, preemptions, timed


def test_preempted_calls_are_apart() -> None:
    spent = np.array([10.0] * 97 + [4000.0] * 3)
    timing = Timed(spent, spent > 1000)
    assert np.percentile(timing.uninterrupted, 99) == 10.0
    assert np.percentile(timing.microseconds, 99) > 1000
    everything = Timed(spent, np.ones(100, dtype=bool))
    assert len(everything.uninterrupted) == 100


def test_every_call_is_made_and_timed() -> None:
    seen: list[int] = []
    timing = timed(seen.append, [1, 2, 3], 7)
    assert len(timing.microseconds) == len(timing.preempted) == 7
    assert seen[-7:] == [1, 2, 3, 1, 2, 3, 1]
    assert (timing.microseconds > 0).all()


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="needs to share a core")
def test_interrupted_calls_on_a_shared_core_are_detected() -> None:
    """Another process uses the same core and preempts some calls."""
    core = min(os.sched_getaffinity(0))
    previous = os.sched_getaffinity(0)
    spin = (
        f"import os\nos.sched_setaffinity(0, {{{core}}})\nprint('on', flush=True)\nwhile True: pass"
    )
    with subprocess.Popen([sys.executable, "-c", spin], stdout=subprocess.PIPE) as other:
        try:
            assert other.stdout is not None
            assert other.stdout.readline() == b"on\n"
            os.sched_setaffinity(0, {core})
            began = preemptions()
            work = np.random.default_rng(0).random((60, 60))
            results = timed(lambda _: work @ work, [0], 200)
            while not results.preempted.any():
                results = timed(lambda _: work @ work, [0], 5000)
            assert preemptions() > began
            # A time slice of the other process is in each of these.
            assert np.median(results.microseconds[results.preempted]) > np.median(
                results.uninterrupted
            )
        finally:
            os.sched_setaffinity(0, previous)
            other.kill()


def test_the_load_is_a_number() -> None:
    assert load() >= 0.0
