"""Unbroken stretches of samples from blocks, with every loss counted."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby, pairwise

from firstcontact.core import Block, counted, merge_blocks


def join(blocks: Sequence[Block]) -> tuple[tuple[Block, ...], tuple[str, ...]]:
    """Join consecutive blocks epoch by epoch.

    Blocks are sorted. The first of repeated samples is used. Nothing is interpolated, and epochs
    are never
    joined.

    Returns
    -------
    stretches
        Unbroken blocks, sorted by epoch and sample number.
    losses
        One sentence for each epoch and kind of loss, with exact counts.
    """
    stretches: list[Block] = []
    losses: list[str] = []
    by_epoch = sorted(blocks, key=lambda b: b.epoch)  # stable: keeps file order within an epoch
    for epoch, group in groupby(by_epoch, key=lambda b: b.epoch):
        joined, trouble = _join_epoch(list(group))
        stretches += joined
        losses += [f"epoch {epoch}: {sentence}" for sentence in trouble]
    return tuple(stretches), tuple(losses)


def _join_epoch(blocks: list[Block]) -> tuple[list[Block], list[str]]:
    trouble: list[str] = []
    late = sum(b.first_sample < a.first_sample for a, b in pairwise(blocks))
    if late:
        trouble.append(f"{late} blocks were out of order and were put back")
    doubled = 0
    accepted: list[Block] = []
    for block in sorted(blocks, key=lambda b: b.first_sample):
        if accepted and block.first_sample < accepted[-1].end:
            overlap = min(accepted[-1].end - block.first_sample, len(block.data))
            doubled += overlap
            block = Block(block.data[overlap:], block.first_sample + overlap, block.epoch)
        if len(block.data):
            accepted.append(block)
    stretches = merge_blocks(accepted)
    gaps = [b.first_sample - a.end for a, b in pairwise(stretches)]
    if doubled:
        trouble.append(f"{doubled} samples came twice; the first were kept")
    if gaps:
        missing = f"{counted(sum(gaps), 'sample')} {'is' if sum(gaps) == 1 else 'are'} missing"
        trouble.append(f"{missing} in {counted(len(gaps), 'gap')}")
    return stretches, trouble
