"""Sensors that belong to no finger: no motor runs before a contact, so closings begin at rest."""

import numpy as np
from hypothesis import example, given, settings
from hypothesis import strategies as st

from firstcontact.contact import ThresholdDetector
from firstcontact.contact.closing import ClosingBegan, Closings, ClosingSamples
from firstcontact.core import Block, Calibration, Channel, ChannelKind, Contact, Layout
from firstcontact.core import VibrationCalibration as Floor

RATE = 4936.0
LAYOUT = Layout((Channel("disc", ChannelKind.VIBRATION, None, "V"),), RATE)
CALIBRATION = Calibration((Floor(None, 0.001, 0.0),))


def tap_signal(times: list[float], seconds: float, rings: float = 0.004) -> np.ndarray:
    """Return a signal at rest with a tap at each of these times, s."""
    rng = np.random.default_rng(0)
    x = 0.001 * rng.standard_normal(round(seconds * RATE))
    t = np.arange(len(x)) / RATE
    for at in times:
        past = np.clip(t - at, 0, None)
        x += np.where(t >= at, 0.2 * np.exp(-past / rings) * np.sin(2500 * past), 0.0)
    return x[:, None]


def run(x: np.ndarray, sizes: list[int]) -> tuple[list[int], list[Contact]]:
    closings = Closings(LAYOUT, ThresholdDetector(10.0), CALIBRATION)
    begun, contacts, place, k = [], [], 0, 0
    while place < len(x):
        size = sizes[k % len(sizes)]
        for stage in closings.update(Block(x[place : place + size], place)):
            if isinstance(stage, ClosingBegan):
                begun.append(stage.sample)
            elif isinstance(stage, ClosingSamples):
                contacts += stage.contacts
        place, k = place + size, k + 1
    return begun, contacts


def test_each_tap_is_one_contact() -> None:
    times = [0.5, 1.0, 1.45, 3.0]
    begun, contacts = run(tap_signal(times, 4.0), [20])
    assert len(contacts) == len(times)
    np.testing.assert_allclose([c.sample / RATE for c in contacts], times, atol=0.001)
    # One for the rest in the beginning, and one behind each tap.
    assert len(begun) == 1 + len(times)
    assert begun[0] / RATE < 0.06
    assert all(0.3 <= b / RATE - t < 0.32 for b, t in zip(begun[1:], times, strict=True))


@settings(max_examples=25)
@given(
    taps=st.lists(
        st.tuples(st.floats(0.1, 1.5), st.floats(0.0003, 0.06), st.floats(0.004, 0.05)),
        min_size=1,
        max_size=6,
    ),
    size=st.integers(100, 10_000),
)
@example(taps=[(0.5, 0.0003, 0.02), (0.65, 0.0003, 0.02)], size=494)
def test_blocks_do_not_matter_for_taps_that_ring(
    taps: list[tuple[float, float, float]], size: int
) -> None:
    """A tap that rings for 42 ms sounds like a motor. Each tap begins, rises and falls, s."""
    x = tap_signal([], 2.0)
    for begin, rises, falls in taps:
        t = np.clip(np.arange(len(x)) / RATE - begin, 0, None)[:, None]
        x += 0.05 * (1 - np.exp(-t / rises)) * np.exp(-t / falls) * np.sin(2500 * t)
    assert run(x, [size]) == run(x, [5])
