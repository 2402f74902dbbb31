"""What a library may take is bounded, and only as long as it is asked for."""

from __future__ import annotations

import resource

import numpy as np
import pytest

from firstcontact.recording._memory import bounded_memory

MIB = 1 << 20


def test_memory_beyond_the_bound_is_not_there() -> None:
    before = resource.getrlimit(resource.RLIMIT_DATA)
    with bounded_memory(256 * MIB):
        assert np.ones(64 * MIB, np.uint8).all()
        with pytest.raises(MemoryError):
            np.ones(1024 * MIB, np.uint8)
    assert resource.getrlimit(resource.RLIMIT_DATA) == before


def test_the_bound_goes_when_what_it_bounds_fails() -> None:
    before = resource.getrlimit(resource.RLIMIT_DATA)
    with pytest.raises(KeyError), bounded_memory(256 * MIB):
        raise KeyError
    assert resource.getrlimit(resource.RLIMIT_DATA) == before
