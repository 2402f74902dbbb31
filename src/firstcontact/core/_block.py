"""Blocks of consecutive samples, as they travel from a source to the models."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, eq=False)
class Block:
    """Consecutive samples from a device, without a gap.

    Parameters
    ----------
    data
        Raw samples as the device sent them, shape (samples, channels).
    first_sample
        Device sample number of ``data[0]``.
    epoch
        Number of the epoch. A restart of the device's sample counter begins a new epoch. Samples
        of different epochs are never joined.

    Examples
    --------
    >>> import numpy as np
    >>> block = Block(np.zeros((5, 16), np.int16), first_sample=1000)
    >>> block.end
    1005
    """

    data: NDArray[Any]
    first_sample: int = 0
    epoch: int = 0

    @property
    def end(self) -> int:
        """Number of the sample after the last one, ``first_sample + len(data)``."""
        return self.first_sample + len(self.data)

    def part(self, first: int, end: int) -> Block:
        """Return a block of the samples numbered ``first`` to ``end`` (exclusive), as a view."""
        data = self.data[first - self.first_sample : end - self.first_sample]
        return Block(data, first, self.epoch)


def merge_blocks(blocks: Iterable[Block], max_samples: float = math.inf) -> list[Block]:
    """Merge blocks that follow each other without a gap. Return as few blocks as possible.

    A merged block has at most ``max_samples`` samples. A longer input block stays unchanged.
    """
    runs: list[list[Block]] = []
    length = 0
    for block in blocks:
        length += len(block.data)
        if runs and length <= max_samples and _follows(block, runs[-1][-1]):
            runs[-1].append(block)
        else:
            runs.append([block])
            length = len(block.data)
    return [
        run[0]
        if len(run) == 1
        else Block(np.concatenate([b.data for b in run]), run[0].first_sample, run[0].epoch)
        for run in runs
    ]


def _follows(block: Block, last: Block) -> bool:
    return (
        block.first_sample == last.end
        and block.epoch == last.epoch
        and block.data.shape[1:] == last.data.shape[1:]
    )
