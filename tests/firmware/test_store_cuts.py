"""Power cuts at any byte while a model is stored: the previous model is intact afterwards."""

import ctypes as c
import zlib
from collections.abc import Callable
from pathlib import Path

import building
import numpy as np
import pytest

FIRMWARE = Path(__file__).parents[2] / "firmware"
#: Bytes of a slot, of its head and of a sector.
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
        ("memory", c.POINTER(_Keeper)),
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
    """Flash with two slots. The power fails after ``left`` bytes were cleared or written."""

    def __init__(self, backwards: bool = False) -> None:
        self.bytes = (c.c_uint8 * (2 * SLOT + 8))()
        c.memset(self.bytes, ERASED, 2 * SLOT)
        self.start = c.addressof(self.bytes) + -c.addressof(self.bytes) % 8
        self.left = 1 << 30
        self.backwards = backwards
        self.memory = _Keeper(None, SLOT, READ(self._read), CLEAR(self._clear), WRITE(self._write))

    def _read(self, context: object, slot: int) -> int:
        return self.start + slot * SLOT

    def _byte(self, at: int, value: int) -> None:
        if self.left:
            self.left -= 1
            c.c_uint8.from_address(self.start + at).value = value

    def _clear(self, context: object, slot: int) -> bool:
        sectors = range(slot * SLOT, (slot + 1) * SLOT, SECTOR)
        for first in reversed(sectors) if self.backwards else sectors:
            for at in range(first, first + SECTOR):
                self._byte(at, ERASED)
        return self.left > 0

    def _write(self, context: object, slot: int, at: int, source: int, n: int) -> bool:
        for k, value in enumerate(c.string_at(source, n)):
            self._byte(slot * SLOT + at + k, value)
        return self.left > 0


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> c.CDLL:
    """Build fc_store with the core."""
    to = tmp_path_factory.mktemp("store") / "store.so"
    predictor, core = FIRMWARE / "predictor", FIRMWARE / "core"
    wire = building.SHARED / "wire"
    files = [predictor / "fc_store.c", *sorted(core.glob("*.c")), *sorted(wire.glob("*.c"))]
    includes = [f"-I{path}" for path in (predictor, core, wire)]
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


def open_store(library: c.CDLL, flash: Flash) -> tuple[_Store, bytes | None]:
    """Return the store as after a start of the device, and the active model."""
    store, n = _Store(), c.c_uint32()
    library.fc_store_open(c.byref(store), c.byref(flash.memory))
    at = library.fc_store_model(c.byref(store), c.byref(n))
    return store, None if at is None else c.string_at(at, n.value)


def keep(library: c.CDLL, store: _Store, model: bytes) -> bool:
    """Store a model as the device does. Return True if it succeeded."""
    reference, why = c.byref(store), c.c_char_p()
    if library.fc_store_begin(reference, len(model), zlib.crc32(model)) is not None:
        return False
    for at in range(0, len(model), 100):
        piece = model[at : at + 100]
        if library.fc_store_chunk(reference, at, piece, len(piece)) is not None:
            return False
    if library.fc_store_whole(reference, c.byref(why)) is None:
        return False
    return library.fc_store_keep(reference) is None


def model(seed: int, n: int = 600) -> bytes:
    return np.random.default_rng(seed).bytes(n)


def cut_everywhere(
    library: c.CDLL, prepare: Callable[[Flash], bytes | None], new: bytes, backwards: bool
) -> set[bytes | None]:
    """Cut the power at each byte while a model is stored. Return all models active afterwards."""
    seen: set[bytes | None] = set()
    cut, succeeded = 0, False
    while not succeeded:
        flash = Flash(backwards)
        old = prepare(flash)
        flash.left = cut
        succeeded = keep(library, open_store(library, flash)[0], new)
        flash.left = 1 << 30
        store, active = open_store(library, flash)
        assert active in (old, new), cut
        assert not succeeded or active == new, cut
        seen.add(active)
        if cut % 37 == 0:  # the next model can be stored
            assert keep(library, store, model(99))
            assert open_store(library, flash)[1] == model(99)
        cut += 1
    assert cut > SLOT + len(new)
    return seen


@pytest.mark.parametrize("backwards", [False, True])
@pytest.mark.parametrize("stored", [0, pytest.param(1, marks=pytest.mark.slow), 2])
def test_cut_at_any_byte_leaves_the_old_model_or_the_new(
    library: c.CDLL, stored: int, backwards: bool
) -> None:
    def prepare(flash: Flash) -> bytes | None:
        for k in range(stored):
            assert keep(library, open_store(library, flash)[0], model(k))
        return open_store(library, flash)[1]

    last = None if stored == 0 else model(stored - 1)
    assert cut_everywhere(library, prepare, model(50, 333), backwards) == {last, model(50, 333)}


def test_cut_while_an_unusable_newer_model_is_replaced_leaves_the_older(library: c.CDLL) -> None:
    """After a firmware update the newer model may be unusable. The older one must survive."""
    new = model(50, 333)
    for cut in range(0, SLOT + len(new) + HEAD, 3):
        flash = Flash()
        for k in range(2):
            assert keep(library, open_store(library, flash)[0], model(k))
        store, _ = open_store(library, flash)
        assert library.fc_store_fall_back(c.byref(store))
        flash.left = cut
        keep(library, store, new)
        flash.left = 1 << 30
        store, active = open_store(library, flash)
        assert active in (model(0), model(1), new)
        if active == model(1):
            assert cut < HEAD
            assert library.fc_store_fall_back(c.byref(store))
            n = c.c_uint32()
            at = library.fc_store_model(c.byref(store), c.byref(n))
            assert c.string_at(at, n.value) == model(0)


def test_turn_counter_wraps(library: c.CDLL) -> None:
    flash = Flash()
    for k in range(2):
        assert keep(library, open_store(library, flash)[0], model(k))
    newest = flash.start + open_store(library, flash)[0].active * SLOT
    c.c_uint32.from_address(newest + 4).value = 0xFFFFFFFF
    c.c_uint32.from_address(flash.start + (newest == flash.start) * SLOT + 4).value = 0xFFFFFFFE
    assert open_store(library, flash)[1] == model(1)
    assert keep(library, open_store(library, flash)[0], model(2))
    assert open_store(library, flash)[1] == model(2)
