"""What loops or crashes in a process of its own is named, and what it gives comes back."""

from __future__ import annotations

import os

import numpy as np
import pytest

from firstcontact.core import InputError
from firstcontact.recording._apart import apart


def double(x: np.ndarray) -> np.ndarray:
    return 2 * x


def loop() -> None:
    while True:
        pass


def refuse() -> None:
    raise InputError("x.h5: object is a link: copy it")


def crash() -> None:
    os.abort()


def test_what_it_gives_comes_back() -> None:
    assert apart(60.0, double, np.arange(3)).tolist() == [0, 2, 4]


def test_what_it_refuses_is_refused() -> None:
    with pytest.raises(InputError, match="object is a link: copy it"):
        apart(60.0, refuse)


def test_what_does_not_end_is_ended() -> None:
    with pytest.raises(OSError, match="reading it does not end"):
        apart(0.2, loop)


def test_a_crash_is_no_crash_of_ours() -> None:
    with pytest.raises(OSError, match="reading it crashes"):
        apart(60.0, crash)
