"""Damaged lines from boards, and damaged time stamps."""

from __future__ import annotations

from pathlib import Path
from random import Random

import fuzz_mutate as mutate
import numpy as np

from firstcontact.device._number_lines import MOST, LineReader
from firstcontact.device._stamped_samples import StampedSamples


def lines(rng: Random, _: Path) -> None:
    """Feed lines of a board in pieces of any size. All numbers that are read must be finite."""
    between = rng.choice((",", ";", "\t", " ", ", "))
    rows = ["n", "left", "right"] if rng.random() < 0.5 else ["0", "1", "2"]
    text = between.join(rows) + "\n"
    for i in range(60):
        words = [str(i), str(rng.randrange(1024)), str(rng.randrange(1024))]
        if rng.random() < 0.1:
            words[rng.randrange(3)] = rng.choice((*mutate.TEXTS, *map(str, mutate.NUMBERS)))
        text += between.join(words) + rng.choice(("\n", "\r\n"))
    stream = text.encode(errors="replace")
    stream = mutate.raw(rng, stream) if rng.random() < 0.5 else stream
    reader, at = LineReader(), 0
    while at < len(stream):
        step = rng.choice((1, 7, 64, 100_000))
        for numbers in reader.feed(stream[at : at + step]):
            if numbers is not None:
                assert 0 < len(numbers) <= MOST
                assert np.isfinite(numbers).all(), "a number that is none"
        at += step


def stamps(rng: Random, _: Path) -> None:
    """Feed stamps that jump, stop, go back or are NaN. Sample numbers must still rise."""
    counted, last, now = StampedSamples(1000.0), -1, rng.choice((0.0, 1e9, -5.0))
    for _ in range(rng.choice((3, 60, 150))):
        n = rng.choice((1, 2, 40))
        if rng.random() < 0.1:
            now += rng.choice((-1.0, 0.5, 30.0, -1e4, 1e6))
        jitter = rng.choice((0.0, 1e-4, 5e-3))
        sample = now + np.arange(n) / 1000.0 + [jitter * rng.gauss(0, 1) for _ in range(n)]
        if rng.random() < 0.1:
            sample[rng.randrange(n)] = rng.choice((np.nan, np.inf, -np.inf, 1e300))
        now += n / 1000.0
        numbers = counted.numbers(sample)
        assert numbers[0] > last, "a number twice"
        assert (np.diff(numbers) > 0).all(), "numbers that do not rise"
        last = int(numbers[-1])
