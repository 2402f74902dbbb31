"""Payloads shared by jobs: one read-only array restores the same values."""

from __future__ import annotations

import numpy as np
import pytest

from firstcontact.core._jobs import ALIGNMENT, pack_payload, unpack_payload


def test_values_round_trip_as_views_of_the_payload() -> None:
    samples = [np.arange(n, dtype=kind) for n, kind in ((3, "f4"), (0, "i8"), (1000, "f8"))]
    names = np.array(["a", "", "long name"])
    turned = np.arange(12.0).reshape(3, 4).T
    payload = pack_payload((samples, names, turned, {"seed": 3}))
    unpacked, unpacked_names, unpacked_turned, options = unpack_payload(payload)
    for was, now in zip(
        [*samples, names, turned], [*unpacked, unpacked_names, unpacked_turned], strict=True
    ):
        np.testing.assert_array_equal(was, now)
        assert was.dtype == now.dtype
        assert not now.flags.writeable
    assert options == {"seed": 3}
    assert np.shares_memory(unpacked[2], payload)
    assert (unpacked[2].ctypes.data - payload.ctypes.data) % ALIGNMENT == 0


def test_common_arrays_are_packed_once() -> None:
    samples = np.zeros(10_000)
    assert pack_payload((samples, {"again": samples})).nbytes < 1.1 * samples.nbytes


def test_last_payload_is_cached() -> None:
    payload, other_payload = pack_payload(([1],)), pack_payload(([1],))
    assert unpack_payload(payload)[0] is unpack_payload(payload.copy())[0]
    assert unpack_payload(other_payload)[0] is not unpack_payload(payload)[0]


def test_unpacked_arrays_are_read_only() -> None:
    (samples,) = unpack_payload(pack_payload((np.zeros(3),)))
    with pytest.raises(ValueError, match="read-only"):
        samples[0] = 1.0


@pytest.mark.parametrize("shift", range(16))
def test_arrays_are_aligned_wherever_the_payload_begins(shift: int) -> None:
    payload = pack_payload((np.arange(9.0),))
    message = np.zeros(len(payload) + 32, np.uint8)
    message = message[-message.ctypes.data % 16 + shift :][: len(payload)]
    message[:] = payload
    (numbers,) = unpack_payload(message)
    assert numbers.flags.aligned
    assert np.array_equal(numbers, np.arange(9.0))
