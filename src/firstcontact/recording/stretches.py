"""Blocks back into unbroken stretches, with every loss counted."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby, pairwise

from firstcontact.core import Block
from firstcontact.core.block import concatenated


def join(blocks: Sequence[Block]) -> tuple[tuple[Block, ...], tuple[str, ...]]:
    """Join blocks that follow each other in sample number, epoch by epoch.

    Blocks out of order are put back; of samples that came twice the first are
    kept. Nothing is interpolated, and epochs are never joined.

    Returns
    -------
    stretches
        Unbroken blocks in the order of epoch and sample number.
    losses
        One sentence for each epoch and kind of trouble, with exact counts.
    """
    stretches: list[Block] = []
    losses: list[str] = []
    by_epoch = sorted(blocks, key=lambda b: b.epoch)  # stable: the file's order within an epoch
    for epoch, group in groupby(by_epoch, key=lambda b: b.epoch):
        joined, trouble = _join_epoch(list(group))
        stretches += joined
        losses += [f"epoch {epoch}: {sentence}" for sentence in trouble]
    return tuple(stretches), tuple(losses)


def _join_epoch(arrived: list[Block]) -> tuple[list[Block], list[str]]:
    trouble: list[str] = []
    late = sum(b.first_sample < a.first_sample for a, b in pairwise(arrived))
    if late:
        trouble.append(f"{late} blocks were out of order and were put back")
    doubled = missing = gaps = 0
    runs: list[list[Block]] = []
    end = 0
    for block in sorted(arrived, key=lambda b: b.first_sample):
        if runs and block.first_sample < end:
            known = min(end - block.first_sample, len(block.data))
            doubled += known
            block = Block(block.data[known:], block.first_sample + known, block.epoch)
        if not len(block.data):
            continue
        if runs and block.first_sample == end:
            runs[-1].append(block)
        else:
            if runs:
                gaps += 1
                missing += block.first_sample - end
            runs.append([block])
        end = block.end
    if doubled:
        trouble.append(f"{doubled} samples came twice; the first were kept")
    if gaps:
        trouble.append(f"{missing} samples are missing in {gaps} gaps")
    return [concatenated(run) for run in runs], trouble
