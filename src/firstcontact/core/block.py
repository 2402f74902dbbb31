"""Consecutive samples as they travel."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
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
        Counts device starts; samples of two epochs are never joined.
    """

    data: NDArray[Any]
    first_sample: int = 0
    epoch: int = 0

    @property
    def end(self) -> int:
        """Sample number that the next block of an unbroken stream starts with."""
        return self.first_sample + len(self.data)


def concatenated(run: Sequence[Block]) -> Block:
    """One block of some that follow each other, one at least."""
    if len(run) == 1:
        return run[0]
    return Block(np.concatenate([b.data for b in run]), run[0].first_sample, run[0].epoch)


def joined(blocks: Iterable[Block]) -> list[Block]:
    """The same samples in as few blocks as can be: those that follow each other become one."""
    runs: list[list[Block]] = []
    for block in blocks:
        last = runs[-1][-1] if runs else None
        if last and (last.end, last.epoch) == (block.first_sample, block.epoch):
            runs[-1].append(block)
        else:
            runs.append([block])
    return [concatenated(run) for run in runs]
