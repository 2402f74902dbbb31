"""Images of models, their arrays by place and kind, and what C makes of spoilt ones."""

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
#: What is said of an image: see images.c.
TRIED = np.dtype(
    [("why", "S72"), ("contacts", "i4"), ("status", "i4", 4), ("spare", "i4"),
     ("value", "f8", 4), ("low", "f8", 4), ("high", "f8", 4)]
)  # fmt: skip
_KERNELS = ("anytime", "detector", "onset", "judge_loudness", "math", "pitch", "whole", "steps")


@dataclass(frozen=True)
class Field:
    """An array of an image: where it lies, of what kind its numbers are, how many there are."""

    at: int
    kind: str
    count: int

    @property
    def size(self) -> int:
        return np.dtype(self.kind).itemsize


@dataclass(frozen=True)
class Patch:
    """An image that is cut to a length, with bytes in other places."""

    length: int
    bytes: tuple[tuple[int, bytes], ...] = ()

    @property
    def told(self) -> bytes:
        parts = [struct.pack("<II", at, len(data)) + data for at, data in self.bytes]
        return struct.pack("<II", self.length, len(parts)) + b"".join(parts)


def fields_of(folder: Path) -> tuple[bytes, list[Field]]:
    """A sound image, and all arrays behind its text."""
    found: list[tuple[str, int, int]] = []
    put = model_image._Writer.put

    def noted(self: Any, values: Any, kind: str) -> None:
        put(self, values, kind)
        found.append((f"<{kind}", np.size(values), len(self.data)))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(model_image._Writer, "put", noted)
        data = hand_image(folder, FLOORS).data
    text = struct.unpack_from("<I", data, 12)[0]
    start = 16 + (text + 7) // 8 * 8
    fields = [Field(start, *found[0][:2])]  # the floors, written by themselves
    start += found[0][2]
    ends = [0, *(end for _, _, end in found[1:])]
    fields += [Field(start + e, kind, n) for e, (kind, n, _) in zip(ends, found[1:], strict=False)]
    assert start + ends[-1] == len(data)
    return data, fields


def program() -> building.Program:
    """images.c with the firmware's own reader and kernels."""
    answers, core = ROOT / "firmware/answers", ROOT / "firmware/core"
    kernels = ROOT / "src/firstcontact/export/c"
    files = [kernels / f"fc_{name}.c" for name in _KERNELS]
    files += [answers / f"fc_{name}.c" for name in ("image", "reach")]
    includes = [f"-I{path}" for path in (answers, core, kernels)]
    return building.Program("images.c", core, {}, [*map(str, files), *includes])


def asked(data: bytes, patches: Sequence[Patch]) -> bytes:
    """As images.c reads them."""
    return struct.pack("<I", len(data)) + data + b"".join(patch.told for patch in patches)


def tried(raw: bytes) -> NDArray[np.void]:
    """The records of images.c."""
    return np.frombuffer(raw, TRIED)
