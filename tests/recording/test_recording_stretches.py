import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from firstcontact.core import Block, counted
from firstcontact.recording._reader import join


def block(first, end):
    return Block(np.arange(first, end)[:, None], first)


@given(st.lists(st.tuples(st.integers(0, 60), st.integers(0, 12)), max_size=12))
def test_any_blocks_are_joined_without_loss_or_duplicates(parts):
    blocks = [block(first, first + n) for first, n in parts]
    stretches, losses = join(blocks)
    joined_numbers = [i for s in stretches for i in range(s.first_sample, s.end)]
    assert joined_numbers == sorted({i for first, n in parts for i in range(first, first + n)})
    for s in stretches:
        assert s.data[:, 0].tolist() == list(range(s.first_sample, s.end))
    total = sum(n for _, n in parts)
    text = " ".join(losses)
    assert (f"{total - len(joined_numbers)} samples came twice" in text) == (
        total > len(joined_numbers)
    )
    missing = (
        joined_numbers[-1] - joined_numbers[0] + 1 - len(joined_numbers) if joined_numbers else 0
    )
    assert (f"missing in {counted(len(stretches) - 1, 'gap')}" in text) == (missing > 0)
