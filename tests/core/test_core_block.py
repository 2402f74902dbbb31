"""Blocks of an unbroken stream meet end to start, and are joined where they do."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from firstcontact.core import Block, merge_blocks


def test_the_end_is_where_the_next_block_starts() -> None:
    first = Block(np.zeros((7, 2)), first_sample=2**40)
    assert first.end == 2**40 + 7
    assert Block(np.zeros((0, 2)), first.end).end == first.end


STEPS = st.tuples(
    st.integers(1, 9),  # samples
    st.sampled_from([0, 0, 0, 2]),  # missing before them
    st.sampled_from([0, 0, 0, 1]),  # whether an epoch begins with them
    st.sampled_from([2, 2, 2, 3]),  # columns
)


@given(st.lists(STEPS), st.sampled_from([1, 10, np.inf]))
def test_joined_are_the_same_samples_in_no_more_blocks_than_it_takes(
    steps: list[tuple[int, int, int, int]], most: float
) -> None:
    blocks, place, epoch = [], 0, 0
    for count, missing, begun, columns in steps:
        place, epoch = place + missing, epoch + begun
        numbers = np.arange(place, place + count)
        blocks.append(Block(np.repeat(numbers[:, None], columns, axis=1), place, epoch))
        place += count
    whole = merge_blocks(blocks, most)

    def samples(parts: list[Block]) -> list[tuple[int, tuple[int, ...]]]:
        return [(b.epoch, tuple(row)) for b in parts for row in b.data.tolist()]

    assert samples(whole) == samples(blocks)
    for block in whole:
        assert block.data[:, 0].tolist() == list(range(block.first_sample, block.end))
        assert len(block.data) <= most or any(block is one for one in blocks)
    for a, b in pairwise(whole):
        apart = (a.end, a.epoch, a.data.shape[1]) != (b.first_sample, b.epoch, b.data.shape[1])
        assert apart or most < np.inf
