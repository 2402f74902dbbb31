"""Times exclude calls that another program interrupted."""

import numpy as np

from firstcontact_lab.study.parts.inference import Timed, measure_durations


def test_preempted_calls_are_apart() -> None:
    spent = np.array([10.0] * 97 + [4000.0] * 3)
    timing = Timed(spent, spent > 1000)
    assert np.percentile(timing.uninterrupted, 99) == 10.0
    assert np.percentile(timing.microseconds, 99) > 1000
    everything = Timed(spent, np.ones(100, dtype=bool))
    assert len(everything.uninterrupted) == 100


def test_every_call_is_made_and_timed() -> None:
    seen: list[int] = []
    timing = measure_durations(seen.append, [1, 2, 3], 7)
    assert len(timing.microseconds) == len(timing.preempted) == 7
    assert seen[-7:] == [1, 2, 3, 1, 2, 3, 1]
    assert (timing.microseconds > 0).all()
