"""Damaged model images: refused or used, without undefined behaviour."""

from pathlib import Path

import building
import numpy as np
import pytest
from images import Field, Patch, intact_image, program, program_input, results
from numpy.typing import NDArray

from random_chains import MODELS

#: Extreme numbers of each type.
EXTREMES: dict[str, list[float]] = {
    "<f4": [np.nan, np.inf, -np.inf, 3.4e38, -3.4e38, 1e29, 1e20, 1e-45, 0.0, -1.0],
    "<f8": [np.nan, np.inf, -np.inf, 1.7e308, -1.7e308, 1e31, 1e-320, 0.0, -1.0],
    "<i4": [0, -1, 1, 2, 9, 75, 256, 1 << 16, 1 << 30, (1 << 31) - 1, -(1 << 31), 0x20000001],
    "<i2": [-32768, 32767, 0, -1],
    "<u1": [0, 34, 255],
}
TOO_LARGE = b"the numbers of the model are too large"


@pytest.fixture(scope="module", params=MODELS)
def intact(request: pytest.FixtureRequest) -> tuple[bytes, list[Field]]:
    return intact_image(request.param)


@pytest.fixture(scope="module")
def strict(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build images.c with sanitizers, which stop it at undefined behaviour."""
    return program().native(tmp_path_factory.mktemp("images") / "strict", strict=True)


def number(field: Field, value: float, k: int = 0) -> tuple[int, bytes]:
    """Return the offset and bytes that set one number of a field."""
    return field.at + k * field.size, np.array(value).astype(field.kind).tobytes()


def all_numbers(field: Field, value: float) -> tuple[int, bytes]:
    return field.at, np.full(field.count, value).astype(field.kind).tobytes()


def damaged(data: bytes, fields: list[Field], seed: int) -> Patch:
    """Return a patch with one of several kinds of damage."""
    rng = np.random.default_rng(seed)
    kind = rng.integers(5)
    if kind == 0:  # cut
        return Patch(int(rng.integers(len(data))) + 1)
    if kind == 1:  # bytes in the lengths at the front, or anywhere
        most = len(data) if rng.random() < 0.5 else 1200
        places = rng.integers(0, most, rng.integers(1, 8)).tolist()
        return Patch(len(data), tuple((p, bytes([rng.integers(256)])) for p in places))
    if kind == 2:  # counts only
        counts = [f for f in fields if f.kind == "<i4"]
        chosen = [counts[k] for k in rng.integers(0, len(counts), rng.integers(1, 3))]
    else:
        chosen = [fields[k] for k in rng.integers(0, len(fields), rng.integers(1, 4))]
    make = all_numbers if kind == 3 else lambda f, v: number(f, v, int(rng.integers(f.count)))
    full = [f for f in chosen if f.count]
    return Patch(len(data), tuple(make(f, float(rng.choice(EXTREMES[f.kind]))) for f in full))


def assert_sane(records: NDArray[np.void]) -> None:
    assert not records["wrong"].any()


def fuzzed(
    strict: Path, intact: tuple[bytes, list[Field]], seeds: range, folder: Path
) -> NDArray[np.void]:
    data, fields = intact
    patches = [damaged(data, fields, seed) for seed in seeds]
    records = results(building.ask_native(strict, program_input(data, patches), folder))
    assert len(records) == len(patches)
    assert_sane(records)
    cut = np.array([patch.length < len(data) for patch in patches])
    assert (records["why"][cut] != b"").all()
    return records


def test_damaged_images_are_refused_or_predict(
    strict: Path, intact: tuple[bytes, list[Field]], tmp_path: Path
) -> None:
    records = fuzzed(strict, intact, range(300), tmp_path)
    assert 20 < (records["why"] == b"").sum() < 280
    assert len(set(records["why"].tolist())) > 4


@pytest.mark.slow
def test_100000_damaged_images_are_refused_or_predict(
    strict: Path, intact: tuple[bytes, list[Field]], tmp_path: Path
) -> None:
    for first in range(1000, 101_000, 5000):
        fuzzed(strict, intact, range(first, first + 5000), tmp_path)


def test_board_and_this_machine_give_the_same_results(
    request: pytest.FixtureRequest, strict: Path, intact: tuple[bytes, list[Field]], tmp_path: Path
) -> None:
    if not building.has_emulator():
        pytest.skip(f"{request.node.name}: gcc-arm-none-eabi or qemu-system-arm is not installed")
    data, fields = intact
    patches = [Patch(len(data)), *(damaged(data, fields, seed) for seed in range(40))]
    native = building.ask_native(strict, program_input(data, patches), tmp_path)
    m7 = building.ask_m7(program().m7(tmp_path / "m7.elf"), program_input(data, patches), tmp_path)
    assert results(native)["why"][0] == b""
    assert results(native)["estimates"][0] > 2
    assert native == m7


def test_weights_that_would_overflow_are_refused(
    strict: Path, intact: tuple[bytes, list[Field]], tmp_path: Path
) -> None:
    """Each patch makes all floats of one array huge, so that rounding to 16 bits fails."""
    data, fields = intact
    floats = [f for f in fields if f.kind == "<f4" and f.count]
    huge = [Patch(len(data), (all_numbers(f, sign * 3.4e38),)) for f in floats for sign in (1, -1)]
    large = [Patch(len(data), (all_numbers(f, x),)) for x in (1e29, 1e6) for f in floats]
    records = results(building.ask_native(strict, program_input(data, huge + large), tmp_path))
    assert_sane(records)
    assert (records["why"][: len(huge)] != b"").all()
    assert (records["why"] == TOO_LARGE).any()
    assert (records["why"][-len(floats) :] == b"").sum() > len(floats) / 2
