"""Calls in a separate process: results are returned, loops and crashes become errors."""

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


def test_result_is_returned() -> None:
    assert apart(60.0, double, np.arange(3)).tolist() == [0, 2, 4]


def test_input_error_is_passed_on() -> None:
    with pytest.raises(InputError, match="object is a link: copy it"):
        apart(60.0, refuse)


def test_endless_function_is_ended() -> None:
    with pytest.raises(OSError, match="reading it does not end"):
        apart(0.2, loop)


def test_crash_is_an_input_error() -> None:
    with pytest.raises(OSError, match="reading it crashes"):
        apart(60.0, crash)
