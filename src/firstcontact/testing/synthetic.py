"""Synthetic pinches and windows for the checks, and assertions that the checks share."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager, suppress

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Contact, Dataset, Finger, InputError, Label, Pinch, fingertip_layout
from firstcontact.core.layout import FINGERTIP_RATE
from firstcontact.signal import ExponentialSmoothing

LAYOUT = fingertip_layout()
SAMPLES = 1200


def closing(seed: int, *, touches: bool = True, session: str = "") -> Pinch:
    rng = np.random.default_rng(seed)
    counts = np.zeros((SAMPLES, 16))
    first = int(rng.integers(450, 700))
    second = first + int(rng.integers(30, 150))
    finger = Finger(int(rng.integers(2)))
    t = np.arange(SAMPLES)
    for f, touched in ((finger, first), (finger.other, second)):
        x = rng.normal(0, 3, SAMPLES) + 4 * np.sin(0.3 * t + 6 * rng.random())
        x[rng.integers(0, SAMPLES, 2)] += rng.normal(0, 30, 2)
        if touches:
            age = t[touched:] - touched
            x[touched:] += rng.uniform(150, 400) * np.exp(-age / 20) * np.sin(0.25 * age + 0.3)
        counts[:, f] = ExponentialSmoothing(0.5).update(x[:, None])[:, 0]
    data = np.rint(np.clip(512 + counts, 0, 1023) * 32).astype(np.int16)
    start = 10_000 * (seed + 1)
    truth = tuple(
        Contact(f, start + s, start + s) for f, s in ((finger, first), (finger.other, second))
    )
    return Pinch(data, LAYOUT, Label(session=session), start, truth if touches else ())


def closings(n: int, seed: int = 0, sessions: int = 4) -> Dataset:
    """Return ``n`` synthetic pinches with known contacts, in turn from each of the sessions."""
    return Dataset(
        tuple(closing(1000 * seed + i, session=f"s{i % sessions}") for i in range(n)), "synthetic"
    )


RATE = FINGERTIP_RATE
LEVELS = (10.0, 29.0, 60.0)


def toy_windows(
    n: int = 180, samples: int = 74, channels: int = 1, seed: int = 0
) -> tuple[NDArray[np.float32], NDArray[np.float64], NDArray[np.str_]]:
    """Return synthetic windows of six sessions, each of which has its own gain.

    They are windows in V, shape (n, samples, channels), and the Shore A and session of each, (n,).
    """
    rng = np.random.default_rng(seed)
    shore = rng.choice(LEVELS, n)
    session = rng.integers(0, 6, n)
    hard = shore + rng.normal(0, 1.0, n)
    gain = np.exp(rng.normal(0, 0.1, 6))[session] * np.exp(rng.normal(0, 0.1, n))
    t = np.arange(samples) / RATE
    rise = np.sin(2 * np.pi * (60 * np.exp(hard / 35))[:, None] * t)
    fall = np.exp(-t / (0.010 * np.exp(-hard / 60))[:, None])
    volts = (0.02 * hard * gain)[:, None] * fall * rise
    X = np.stack([volts] * channels, axis=2) + rng.normal(0, 0.01, (n, samples, channels))
    return X.astype(np.float32), shore, session.astype(np.str_)


def refused(words: str, call: Callable[[], object]) -> None:
    """Assert that a call raises an InputError whose message contains ``words``."""
    message = None
    try:
        call()
    except InputError as error:
        message = str(error)
    assert message is not None, f"not refused; expected an InputError with {words!r}"
    assert words in message, f"refused, but without {words!r}: {message}"


def passes_exceptions(opened: AbstractContextManager[object], what: str) -> None:
    """Assert that an exception in the ``with`` block of a hand or a source reaches the caller.

    ``what`` names the hand or source in the message.
    """
    with suppress(ZeroDivisionError):
        with opened:
            raise ZeroDivisionError
        raise AssertionError(
            f"the with block of the {what} swallows an exception: __exit__ must not return True"
        )
