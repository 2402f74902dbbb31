"""Windows after a contact: complete or refused, equal offline and live."""

from dataclasses import replace

import numpy as np

from firstcontact.core import Contact, Dataset, Finger, Pinch, fingertip_layout
from firstcontact.signal import contact_windows, samples_in

LAYOUT = fingertip_layout()
FIRST = 5000
DURATION = 0.015


def pinch(n: int = 600, seed: int = 0, layout=LAYOUT) -> Pinch:
    data = np.random.default_rng(seed).normal(16384, 60, (n, 16)).astype(np.int16)
    return Pinch(data, layout, first_sample=FIRST)


def contact(position: int, finger: Finger = Finger.INDEX) -> Contact:
    return Contact(finger, FIRST + position, FIRST + position + 10)


def test_samples_in_rounds():
    assert samples_in(0.015, 4936.0) == 74
    assert samples_in(0.002, 4936.0) == 10


def test_windows_start_at_the_contact_with_the_quiet_removed():
    data = np.full((600, 16), 16384.0, dtype=np.float32)
    data[:, 0] += 1000.0
    # Slow against the filter, so that it leaves the ramp as it is.
    data[300:, 0] += np.arange(300.0) * 10
    p = Pinch(data, LAYOUT, first_sample=FIRST)
    X, is_valid = contact_windows(Dataset((p,)), [contact(310)], DURATION)
    volts = (np.arange(74) + 10) * 10 * LAYOUT.channels[0].scale
    assert is_valid.tolist() == [True]
    assert X.shape == (1, 74, 1)
    assert X.dtype == np.float32
    np.testing.assert_allclose(X[0, :, 0], volts, rtol=0.05)


def test_incomplete_windows_are_dropped():
    last_start = 600 - 74 - 2  # the filter looks ahead two samples
    cases = {
        "none": (None, False),
        "last whole": (contact(last_start), True),
        "past the end": (contact(last_start + 1), False),
        "no quiet before": (contact(15), False),
        "just enough quiet": (contact(20), True),
        "before the pinch": (contact(-30), False),
    }
    p = pinch()
    X, is_valid = contact_windows(
        Dataset((p,) * len(cases)), [c for c, _ in cases.values()], DURATION
    )
    assert is_valid.tolist() == [expected for _, expected in cases.values()]
    assert len(X) == is_valid.sum()


def test_flat_and_not_finite_windows_are_dropped():
    flat = Pinch(np.full((600, 16), 16384, dtype=np.int16), LAYOUT, first_sample=FIRST)
    holed = pinch().data.astype(np.float32)
    holed[320] = np.nan
    X, is_valid = contact_windows(
        Dataset((flat, Pinch(holed, LAYOUT, first_sample=FIRST))), [contact(300)] * 2, DURATION
    )
    assert not is_valid.any()
    assert X.shape == (0, 74, 1)


def test_smoothed_data_are_not_smoothed_again():
    raw_layout = replace(LAYOUT, smoothing_alpha=1.0)
    # The same numbers, once said to be raw: only those lose noise.
    as_is, _ = contact_windows(Dataset((pinch(),)), [contact(300)], DURATION)
    smoothed, _ = contact_windows(Dataset((pinch(layout=raw_layout),)), [contact(300)], DURATION)
    assert smoothed.std() < 0.9 * as_is.std()
