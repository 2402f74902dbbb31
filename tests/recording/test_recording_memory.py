"""Memory limits for libraries, within a context."""

from __future__ import annotations

import resource

import numpy as np
import pytest

from firstcontact.recording._memory import bounded_memory

MIB = 1 << 20


def test_memory_beyond_the_bound_raises() -> None:
    limits = resource.getrlimit(resource.RLIMIT_DATA)
    with bounded_memory(256 * MIB):
        assert np.ones(64 * MIB, np.uint8).all()
        with pytest.raises(MemoryError):
            np.ones(1024 * MIB, np.uint8)
    assert resource.getrlimit(resource.RLIMIT_DATA) == limits


def test_bound_ends_after_an_error() -> None:
    limits = resource.getrlimit(resource.RLIMIT_DATA)
    with pytest.raises(KeyError), bounded_memory(256 * MIB):
        raise KeyError
    assert resource.getrlimit(resource.RLIMIT_DATA) == limits
