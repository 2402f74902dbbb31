"""Model images for tests: their arrays, patches that damage them, and the results of C."""

import struct
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import building
import numpy as np
import pytest
from numpy.typing import NDArray

from firstcontact.chain import image
from firstcontact.chain.constants import DetectorKind
from random_chains import random_image

#: Record of images.c for each image.
RESULT = np.dtype(
    [("why", "S72"), ("contacts", "i4"), ("estimates", "i4"), ("wrong", "i4"), ("unused", "i4"),
     ("value", "f4"), ("low", "f4"), ("high", "f4"), ("spread", "f4")]
)  # fmt: skip


@dataclass(frozen=True)
class Field:
    """Array of an image: offset, type and number of elements."""

    at: int
    kind: str
    count: int

    @property
    def size(self) -> int:
        return np.dtype(self.kind).itemsize


@dataclass(frozen=True)
class Patch:
    """Change to an image: its new length, and bytes to replace."""

    length: int
    bytes: tuple[tuple[int, bytes], ...] = ()

    @property
    def encoded(self) -> bytes:
        parts = [struct.pack("<II", at, len(data)) + data for at, data in self.bytes]
        return struct.pack("<II", self.length, len(parts)) + b"".join(parts)


def intact_image(model: str = "network") -> tuple[bytes, list[Field]]:
    """Return an intact image with a random model, and all its arrays."""
    arrays: list[Field] = []
    put = image.ArrayWriter.put

    def put_and_note(self: Any, values: Any, kind: str) -> None:
        arrays.append(Field(16 + len(self.data), f"<{kind}", np.size(values)))
        put(self, values, kind)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(image.ArrayWriter, "put", put_and_note)
        data = random_image(3, DetectorKind.THRESHOLD, model, text='{"model":"a"}').data
    return data, arrays


def program() -> building.Program:
    """Return images.c with the chain's own files."""
    return building.chain_program("images.c", Path("no-further-sources"))


def program_input(data: bytes, patches: Sequence[Patch]) -> bytes:
    """Return an image and its patches as input for images.c."""
    return struct.pack("<I", len(data)) + data + b"".join(patch.encoded for patch in patches)


def results(raw: bytes) -> NDArray[np.void]:
    """Return the records of images.c."""
    return np.frombuffer(raw, RESULT)
