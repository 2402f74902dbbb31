"""The chain finds the reference's closings and contacts, and names the fault of refused samples."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from detection_reference import Event, run
from numpy.typing import NDArray
from random_streams import RandomStream, random_stream

from firstcontact.chain import Chain, ChainEvent, EventKind, build_image
from firstcontact.chain.constants import NO_DETECTOR, DetectorConstants, DetectorKind
from firstcontact.core import Block, Channel, ChannelKind, Finger, InputError, Layout


def computed(
    random: RandomStream, sizes: np.random.Generator | None, **options: object
) -> list[Event]:
    """Return the chain's events, in whole stretches or in blocks of random sizes."""
    chain = random.chain(**options)
    events: list[ChainEvent] = []
    for block in random.blocks:
        start = 0
        while start < len(block.data):
            stop = len(block.data) if sizes is None else start + int(sizes.integers(1, 40))
            piece = block.data[start:stop]
            events += chain.take(Block(piece, block.first_sample + start, block.epoch))
            start = stop
    events += chain.finish()
    return [tuple(event[:6]) for event in events]  # type: ignore[misc]


#: Numbers of random streams: the first ones in each run of the tests, all in slow runs.
FEW = [range(1000)]
MANY = [range(k, k + 10_000) for k in range(0, 100_000, 10_000)]


@pytest.mark.parametrize(
    "seeds", [*FEW, *(pytest.param(seeds, marks=pytest.mark.slow) for seeds in MANY)], ids=str
)
def test_events_are_those_of_the_reference(seeds: range) -> None:
    counts: Counter[int] = Counter()
    for seed in seeds:
        random = random_stream(seed)
        events = computed(random, None)
        assert events == run(random.stream, random.stretches), seed
        counts.update(event[0] for event in events)
    for kind in EventKind.CLOSING_BEGAN, EventKind.CONTACT_FOUND, EventKind.CONTACT_WITHDRAWN:
        assert counts[kind] > len(seeds) / 20


@pytest.mark.parametrize(
    "seeds",
    [range(4000), *(pytest.param(seeds, marks=pytest.mark.slow) for seeds in MANY)],
    ids=str,
)
def test_events_do_not_depend_on_the_sizes_of_blocks(seeds: range) -> None:
    for seed in seeds:
        random = random_stream(seed)
        assert computed(random, None) == computed(random, np.random.default_rng(seed)), seed


class Python:
    """Threshold detector in Python."""

    def __init__(self, step: int, threshold: float) -> None:
        self.step, self.threshold = step, threshold
        self.quiet: list[NDArray[np.float64]] = []

    def settled(self, quiet: NDArray[np.float64]) -> None:
        self.quiet.append(quiet)

    def fires(self, windows: NDArray[np.float64]) -> NDArray[np.bool_]:
        return np.asarray((np.abs(windows[..., -self.step :]) > self.threshold).any(axis=2))


def test_detector_in_python_finds_the_same_contacts() -> None:
    compared = 0
    for seed in range(200):
        random = random_stream(seed)
        constants = random.stream.constants
        if constants.kind == DetectorKind.LOGISTIC:
            continue
        program = replace(constants, kind=DetectorKind.PYTHON)
        detector = Python(constants.step, constants.threshold)
        same = replace(random, stream=replace(random.stream, constants=program))
        assert computed(same, None, detector=detector) == computed(random, None)
        compared += 1
        for quiet in detector.quiet[:1]:
            varies = np.ptp(quiet, axis=0) > 0
            np.testing.assert_allclose(quiet.mean(axis=0), 0.0, atol=1e-9)
            np.testing.assert_allclose(quiet.std(axis=0), varies, atol=1e-9)
    assert compared > 50


def test_windows_of_a_trace_are_those_of_all_samples() -> None:
    """A traced chain judges all windows, also after the contacts, and finds the same ones."""
    for seed in range(100):
        random = random_stream(seed)
        random = replace(random, stream=replace(random.stream, after=1000.0))
        chain = random.chain(is_traced=True)
        events, rows = [], []
        for block in random.blocks:
            events += chain.take(block)
            rows += chain.windows
        events += chain.finish()
        assert [tuple(event[:6]) for event in events] == computed(random, None)
        onsets = {onset for row in rows for onset in row[1:]}
        found = {e.sample for e in events if e.kind == EventKind.CONTACT_FOUND}
        assert found <= onsets


@pytest.mark.parametrize("kind", DetectorKind)
@pytest.mark.parametrize(
    "sizes",
    [
        {"window": -6},
        {"window": 1 << 20},
        {"step": 0},
        {"steady": -1},
        {"steady": 1 << 20},
        {"search": 2},
        {"looks": 0},
    ],
)
def test_image_with_impossible_sizes_is_refused(kind: DetectorKind, sizes: dict[str, int]) -> None:
    constants = replace(NO_DETECTOR, kind=kind, **sizes)
    with pytest.raises(InputError, match="do not fit"):
        assert build_image(5000.0, constants).handle


LAYOUT = Layout((Channel("piezo", ChannelKind.VIBRATION, Finger.INDEX, "V"),), rate=1000.0)
SAMPLES = np.random.default_rng(1).standard_normal((50, 1))


@pytest.mark.parametrize("first", [-1, -(2**40)])
def test_a_negative_first_sample_is_no_wrong_width(first: int) -> None:
    chain = Chain(build_image(1000.0, NO_DETECTOR), LAYOUT)
    with pytest.raises(ValueError, match="first sample"):
        chain.take(Block(SAMPLES, first))
    assert chain.take(Block(SAMPLES, 0))


def test_a_chain_in_use_is_no_wrong_width() -> None:
    class Reentrant:
        def settled(self, quiet: NDArray[np.float64]) -> None:
            chain.take(Block(SAMPLES, 50))

        def fires(self, windows: NDArray[np.float64]) -> NDArray[np.bool_]:
            return np.zeros(windows.shape[:2], bool)

    constants = DetectorConstants(DetectorKind.PYTHON, 10, 2, 20, 5)
    chain = Chain(build_image(1000.0, constants), LAYOUT, detector=Reentrant())
    with pytest.raises(ValueError, match="in use"):
        chain.take(Block(SAMPLES, 0))
