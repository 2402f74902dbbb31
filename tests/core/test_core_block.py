"""Consecutive blocks join without gap or overlap."""

from itertools import pairwise

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from firstcontact.core import Block, merge_blocks

STEPS = st.tuples(
    st.integers(1, 9),  # samples
    st.sampled_from([0, 0, 0, 2]),  # missing before them
    st.sampled_from([0, 0, 0, 1]),  # whether an epoch begins with them
    st.sampled_from([2, 2, 2, 3]),  # columns
)


@given(st.lists(STEPS), st.sampled_from([1, 10, np.inf]))
def test_merged_blocks_are_few_and_keep_all_samples(steps, limit):
    blocks, place, epoch = [], 0, 0
    for count, missing, begun, columns in steps:
        place, epoch = place + missing, epoch + begun
        numbers = np.arange(place, place + count)
        blocks.append(Block(np.repeat(numbers[:, None], columns, axis=1), place, epoch))
        place += count
    merged = merge_blocks(blocks, limit)

    def samples(parts):
        return [(b.epoch, tuple(row)) for b in parts for row in b.data.tolist()]

    assert samples(merged) == samples(blocks)
    for block in merged:
        assert block.data[:, 0].tolist() == list(range(block.first_sample, block.end))
        assert len(block.data) <= limit or any(block is original for original in blocks)
    for a, b in pairwise(merged):
        is_break = (a.end, a.epoch, a.data.shape[1]) != (b.first_sample, b.epoch, b.data.shape[1])
        assert is_break or limit < np.inf
