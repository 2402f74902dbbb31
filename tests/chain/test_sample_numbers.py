"""The numbers of samples may grow for months: events do not depend on them."""

from dataclasses import replace

import numpy as np
import pytest

from firstcontact.chain import ChainEvent, EventKind, Image, build_image
from firstcontact.chain.constants import DetectorKind
from firstcontact.core.layout import FINGERTIP_RATE
from random_chains import FLOOR, Stream, python_events, random_detector, random_model

CONTACT, END = 300, 420


def events(image: Image, data: np.ndarray, first: int) -> list[ChainEvent]:
    """Return the events of a closing, with numbers relative to its first sample."""
    stream = Stream([(first, 0, data)], 0, False, 1.0, (0.0, 0.1, np.nan))
    found = python_events(image, stream)
    return [
        event._replace(sample=event.sample - first, known=event.known - first) for event in found
    ]


@pytest.mark.parametrize("step", [2, 5, 6])
@pytest.mark.parametrize("number", [1 << 31, 1 << 32, 1 << 40])
def test_a_closing_around_any_number_has_the_same_events(step: int, number: int) -> None:
    estimates = 0
    for seed in range(4):
        rng = np.random.default_rng(seed)
        detector = random_detector(rng, DetectorKind.LOGISTIC)
        detector = replace(detector, step=step, window=99 + 3 * step)
        image = build_image(FINGERTIP_RATE, detector, random_model(rng))
        data = 4 * rng.normal(0.0, FLOOR, (END, 2)).astype(np.float32)
        for finger, at in enumerate((CONTACT, CONTACT + 8)):
            data[at:, finger] += rng.uniform(0.05, 0.5) * np.sin(0.2 * np.arange(END - at))
        wanted = events(image, data, 1000)
        estimates += sum(event.kind == EventKind.ESTIMATED for event in wanted)
        for after in range(0, 40):
            np.testing.assert_equal(events(image, data, number - CONTACT - after), wanted)
    assert estimates > 10
