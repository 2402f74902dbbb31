"""Blocks of an unbroken stream meet end to start."""

from __future__ import annotations

import numpy as np

from firstcontact.core import Block


def test_the_end_is_where_the_next_block_starts() -> None:
    first = Block(np.zeros((7, 2)), first_sample=2**40)
    assert first.end == 2**40 + 7
    assert Block(np.zeros((0, 2)), first.end).end == first.end
