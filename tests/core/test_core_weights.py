"""Weights on disk and their checksum."""

from __future__ import annotations

from pathlib import Path

import pytest

from firstcontact.core import InputError
from firstcontact.core.weights import digest, read_verified

RAW = bytes(range(256))


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "weights"
    path.write_bytes(RAW)
    return path


def test_the_bytes_of_the_checksum_are_read(file: Path) -> None:
    assert read_verified(file, digest(RAW), "model.json", len(RAW)) == RAW


@pytest.mark.parametrize("place", [0, 100, 255])
def test_a_flipped_bit_is_refused_with_file_and_field(file: Path, place: int) -> None:
    damaged = bytearray(RAW)
    damaged[place] ^= 1
    file.write_bytes(damaged)
    with pytest.raises(InputError, match="sha256") as error:
        read_verified(file, digest(RAW), "model.json", len(RAW))
    assert str(file) in str(error.value)
