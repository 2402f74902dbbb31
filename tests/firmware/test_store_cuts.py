"""The power may go at any byte while a model is kept: the one before is whole at the next start."""

from __future__ import annotations

import ctypes as c
import zlib
from collections.abc import Callable
from pathlib import Path

import building
import numpy as np
import pytest

FIRMWARE = Path(__file__).parents[2] / "firmware"
#: Bytes of a place, and of its head; a flash is cleared sector by sector.
SLOT, HEAD, SECTOR = 640, 16, 64
ERASED = 0xFF
READ = c.CFUNCTYPE(c.c_void_p, c.c_void_p, c.c_int)
CLEAR = c.CFUNCTYPE(c.c_bool, c.c_void_p, c.c_int)
WRITE = c.CFUNCTYPE(c.c_bool, c.c_void_p, c.c_int, c.c_uint32, c.c_void_p, c.c_uint32)


class _Keeper(c.Structure):
    _fields_ = [
        ("own", c.c_void_p),
        ("slot_bytes", c.c_uint32),
        ("read", READ),
        ("clear", CLEAR),
        ("write", WRITE),
    ]


class _Store(c.Structure):
    _fields_ = [
        ("keeper", c.POINTER(_Keeper)),
        ("active", c.c_int),
        ("bytes", c.c_uint32),
        ("turn", c.c_uint32),
        ("taking", c.c_bool),
        ("kept", c.c_bool),
        ("length", c.c_uint32),
        ("crc", c.c_uint32),
        ("next", c.c_uint32),
    ]


class Flash:
    """Two places whose power goes after so many bytes were cleared or written."""

    def __init__(self, backwards: bool = False) -> None:
        self.bytes = (c.c_uint8 * (2 * SLOT + 8))()
        c.memset(self.bytes, ERASED, 2 * SLOT)
        self.start = c.addressof(self.bytes) + -c.addressof(self.bytes) % 8
        self.left = 1 << 30
        self.backwards = backwards
        self.keeper = _Keeper(None, SLOT, READ(self._read), CLEAR(self._clear), WRITE(self._write))

    def _read(self, own: object, slot: int) -> int:
        return self.start + slot * SLOT

    def _byte(self, at: int, value: int) -> None:
        if self.left:
            self.left -= 1
            c.c_uint8.from_address(self.start + at).value = value

    def _clear(self, own: object, slot: int) -> bool:
        sectors = range(slot * SLOT, (slot + 1) * SLOT, SECTOR)
        for first in reversed(sectors) if self.backwards else sectors:
            for at in range(first, first + SECTOR):
                self._byte(at, ERASED)
        return self.left > 0

    def _write(self, own: object, slot: int, at: int, source: int, n: int) -> bool:
        for k, value in enumerate(c.string_at(source, n)):
            self._byte(slot * SLOT + at + k, value)
        return self.left > 0


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> c.CDLL:
    """fc_store with what it needs of the core."""
    to = tmp_path_factory.mktemp("store") / "store.so"
    answers, core = FIRMWARE / "answers", FIRMWARE / "core"
    kernels = FIRMWARE.parent / "src/firstcontact/export/c"
    files = [answers / "fc_store.c", *sorted(core.glob("*.c"))]
    includes = [f"-I{path}" for path in (answers, core, kernels)]
    building.run(
        ["gcc", *building.WARN, *building.PLAIN, "-shared", "-fPIC", *includes,
         *map(str, files), "-o", str(to)]
    )  # fmt: skip
    loaded = c.CDLL(str(to))
    loaded.fc_store_model.restype = c.c_void_p
    for name in ("begin", "chunk", "keep"):
        getattr(loaded, f"fc_store_{name}").restype = c.c_char_p
    loaded.fc_store_whole.restype = c.c_void_p
    return loaded


def opened(library: c.CDLL, flash: Flash) -> tuple[_Store, bytes | None]:
    """The store after a start, and the model that counts."""
    store, n = _Store(), c.c_uint32()
    library.fc_store_open(c.byref(store), c.byref(flash.keeper))
    at = library.fc_store_model(c.byref(store), c.byref(n))
    return store, None if at is None else c.string_at(at, n.value)


def keep(library: c.CDLL, store: _Store, model: bytes) -> bool:
    """As the device does with what comes over the wire."""
    own, why = c.byref(store), c.c_char_p()
    if library.fc_store_begin(own, len(model), zlib.crc32(model)) is not None:
        return False
    for at in range(0, len(model), 100):
        piece = model[at : at + 100]
        if library.fc_store_chunk(own, at, piece, len(piece)) is not None:
            return False
    if library.fc_store_whole(own, c.byref(why)) is None:
        return False
    return library.fc_store_keep(own) is None


def model(seed: int, n: int = 600) -> bytes:
    return np.random.default_rng(seed).bytes(n)


def cut_everywhere(
    library: c.CDLL, before: Callable[[Flash], bytes | None], new: bytes, backwards: bool
) -> set[bytes | None]:
    """What counts after the power went at each byte of keeping a model, and then after all went
    well."""
    seen: set[bytes | None] = set()
    cut, done = 0, False
    while not done:
        flash = Flash(backwards)
        old = before(flash)
        flash.left = cut
        done = keep(library, opened(library, flash)[0], new)
        flash.left = 1 << 30
        store, found = opened(library, flash)
        assert found in (old, new), cut
        assert not done or found == new, cut
        seen.add(found)
        if cut % 37 == 0:  # and the next one that comes is kept
            assert keep(library, store, model(99))
            assert opened(library, flash)[1] == model(99)
        cut += 1
    assert cut > SLOT + len(new)
    return seen


@pytest.mark.parametrize("backwards", [False, True])
@pytest.mark.parametrize("kept", [0, 1, 2])
def test_a_cut_at_any_byte_leaves_the_old_model_or_the_new(
    library: c.CDLL, kept: int, backwards: bool
) -> None:
    def before(flash: Flash) -> bytes | None:
        for k in range(kept):
            assert keep(library, opened(library, flash)[0], model(k))
        return opened(library, flash)[1]

    last = None if kept == 0 else model(kept - 1)
    assert cut_everywhere(library, before, model(50, 333), backwards) == {last, model(50, 333)}


def test_a_cut_while_a_useless_newer_model_is_replaced_leaves_the_older(library: c.CDLL) -> None:
    """The newer is whole and not used, as after an update: whichever counts at the next start,
    the older is there."""
    new = model(50, 333)
    for cut in range(0, SLOT + len(new) + HEAD, 3):
        flash = Flash()
        for k in range(2):
            assert keep(library, opened(library, flash)[0], model(k))
        store, _ = opened(library, flash)
        assert library.fc_store_fall_back(c.byref(store))
        flash.left = cut
        keep(library, store, new)
        flash.left = 1 << 30
        store, found = opened(library, flash)
        assert found in (model(0), model(1), new)
        if found == model(1):
            assert cut < HEAD
            assert library.fc_store_fall_back(c.byref(store))
            n = c.c_uint32()
            at = library.fc_store_model(c.byref(store), c.byref(n))
            assert c.string_at(at, n.value) == model(0)


def test_turns_wrap(library: c.CDLL) -> None:
    flash = Flash()
    for k in range(2):
        assert keep(library, opened(library, flash)[0], model(k))
    newest = flash.start + opened(library, flash)[0].active * SLOT
    c.c_uint32.from_address(newest + 4).value = 0xFFFFFFFF
    c.c_uint32.from_address(flash.start + (newest == flash.start) * SLOT + 4).value = 0xFFFFFFFE
    assert opened(library, flash)[1] == model(1)
    assert keep(library, opened(library, flash)[0], model(2))
    assert opened(library, flash)[1] == model(2)
