"""What jobs share: the same values again, in one array, and nobody changes them."""

from __future__ import annotations

import numpy as np
import pytest

from firstcontact.core._shared_payload import ALIGNMENT, pack_payload, unpack_payload


def test_values_come_back_with_their_arrays_inside_the_one_array() -> None:
    samples = [np.arange(n, dtype=kind) for n, kind in ((3, "f4"), (0, "i8"), (1000, "f8"))]
    names = np.array(["a", "", "long name"])
    turned = np.arange(12.0).reshape(3, 4).T
    whole = pack_payload((samples, names, turned, {"seed": 3}))
    again, words, other, options = unpack_payload(whole)
    for was, now in zip([*samples, names, turned], [*again, words, other], strict=True):
        np.testing.assert_array_equal(was, now)
        assert was.dtype == now.dtype
        assert not now.flags.writeable
    assert options == {"seed": 3}
    assert np.shares_memory(again[2], whole)
    assert (again[2].ctypes.data - whole.ctypes.data) % ALIGNMENT == 0


def test_what_two_values_have_in_common_travels_once() -> None:
    samples = np.zeros(10_000)
    assert pack_payload((samples, {"again": samples})).nbytes < 1.1 * samples.nbytes


def test_the_last_values_are_opened_once_and_others_are_told_apart() -> None:
    one, other = pack_payload(([1],)), pack_payload(([1],))
    assert unpack_payload(one)[0] is unpack_payload(one.copy())[0]
    assert unpack_payload(other)[0] is not unpack_payload(one)[0]


def test_a_job_that_changes_what_is_shared_is_refused() -> None:
    (samples,) = unpack_payload(pack_payload((np.zeros(3),)))
    with pytest.raises(ValueError, match="read-only"):
        samples[0] = 1.0
