"""A live session is the same with and without the compiled kernels."""

from __future__ import annotations

import pytest
from streams import cut_frames, run

from compiled_kernels import built_kernels, using
from firstcontact.contact import Detector
from firstcontact.core import Dataset, fingertip_layout
from firstcontact.models import InContextModel
from firstcontact.streaming import Event, NetworkPredictor, PinchDone, Pipeline

LAYOUT = fingertip_layout()


def pinches(events: list[Event]) -> list[PinchDone]:
    return [event for event in events if isinstance(event, PinchDone)]


@pytest.mark.parametrize("real_time", [True, False])
def test_events_are_those_of_numpy(
    fresh: Dataset, detector: Detector, anytime: InContextModel, real_time: bool
) -> None:
    by_kernel = []
    for module in (built_kernels(), None):
        with using(module):
            pipeline = Pipeline(LAYOUT, detector, NetworkPredictor(anytime), real_time=real_time)
            by_kernel.append(pinches(run(pipeline, cut_frames(fresh))))
    assert len(by_kernel[0]) == len(fresh)
    for compiled, plain in zip(*by_kernel, strict=True):
        assert (compiled.start, compiled.end) == (plain.start, plain.end)
        assert compiled.contacts == plain.contacts
        assert len(compiled.estimates) == len(plain.estimates)
        for a, b in zip(compiled.estimates, plain.estimates, strict=True):
            assert (a.elapsed, a.complete, a.final) == (b.elapsed, b.complete, b.final)
            assert a.out_of_range == b.out_of_range
            numbers = (b.value, b.low, b.high)
            assert (a.value, a.low, a.high) == pytest.approx(numbers, rel=1e-5, abs=2e-4)
