"""Model images for tests: their arrays, patches that damage them, and the results of C."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import building
import numpy as np
import pytest
from hand import FLOORS
from numpy.typing import NDArray

from firstcontact.export import _model_image as model_image
from firstcontact.export import hand_image

ROOT = Path(__file__).parents[2]
#: Record of images.c for each image.
RESULT = np.dtype(
    [("why", "S72"), ("contacts", "i4"), ("status", "i4", 4), ("spare", "i4"),
     ("value", "f8", 4), ("low", "f8", 4), ("high", "f8", 4)]
)  # fmt: skip
_KERNELS = ("anytime", "detector", "onset", "judge_loudness", "math", "pitch", "whole", "steps")


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


def intact_image(folder: Path) -> tuple[bytes, list[Field]]:
    """Return an intact image and all arrays after its text."""
    arrays: list[tuple[str, int, int]] = []
    put = model_image._Writer.put

    def put_and_note(self: Any, values: Any, kind: str) -> None:
        put(self, values, kind)
        arrays.append((f"<{kind}", np.size(values), len(self.data)))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(model_image._Writer, "put", put_and_note)
        data = hand_image(folder, FLOORS).data
    text = struct.unpack_from("<I", data, 12)[0]
    start = 16 + (text + 7) // 8 * 8
    fields = [Field(start, *arrays[0][:2])]  # the noise floors come first
    start += arrays[0][2]
    ends = [0, *(end for _, _, end in arrays[1:])]
    fields += [Field(start + e, kind, n) for e, (kind, n, _) in zip(ends, arrays[1:], strict=False)]
    assert start + ends[-1] == len(data)
    return data, fields


def program() -> building.Program:
    """Return images.c with the firmware's reader and kernels."""
    answers, core = ROOT / "firmware/answers", ROOT / "firmware/core"
    kernels = ROOT / "src/firstcontact/export/c"
    files = [kernels / f"fc_{name}.c" for name in _KERNELS]
    files += [answers / f"fc_{name}.c" for name in ("image", "reach")]
    includes = [f"-I{path}" for path in (answers, core, kernels)]
    return building.Program("images.c", core, {}, [*map(str, files), *includes])


def program_input(data: bytes, patches: Sequence[Patch]) -> bytes:
    """Return an image and its patches as input for images.c."""
    return struct.pack("<I", len(data)) + data + b"".join(patch.encoded for patch in patches)


def results(raw: bytes) -> NDArray[np.void]:
    """Return the records of images.c."""
    return np.frombuffer(raw, RESULT)
