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
    """Consecutive samples of one epoch.

    Parameters
    ----------
    data
        Raw samples, shape (samples, channels).
    first_sample
        Device sample number of ``data[0]``.
    epoch
        Number of the epoch, a run of the device's sample counter. Samples of different epochs are
        never joined.

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
        """Sample number at which the next block of an unbroken stream starts."""
        return self.first_sample + len(self.data)


def merge_blocks(blocks: Iterable[Block], max_samples: float = math.inf) -> list[Block]:
    """Return the same samples in as few blocks as possible. Consecutive blocks are merged.

    A merged block has at most ``max_samples`` samples. A longer input block stays as it is.
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
