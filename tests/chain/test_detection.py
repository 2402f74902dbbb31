"""The chain's closings and contacts are those of the reference, whatever the sizes of blocks."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
from random_streams import RandomStream, random_stream
from reference import Event, run

from firstcontact.chain import ChainEvent, EventKind
from firstcontact.core import Block


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


@pytest.mark.parametrize(
    "seeds", [range(10_000), pytest.param(range(10_000, 110_000), marks=pytest.mark.slow)], ids=len
)
@pytest.mark.timeout(0)
def test_events_are_those_of_the_reference(seeds: range) -> None:
    counts: Counter[int] = Counter()
    for seed in seeds:
        random = random_stream(seed)
        events = computed(random, None)
        assert events == run(random.stream, random.stretches), seed
        assert events == computed(random, np.random.default_rng(seed)), seed
        counts.update(event[0] for event in events)
    for kind in EventKind.CLOSING_BEGAN, EventKind.CONTACT_FOUND, EventKind.CONTACT_WITHDRAWN:
        assert counts[kind] > len(seeds) / 20
