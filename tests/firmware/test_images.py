"""Damaged model images: refused or used, without undefined behaviour."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import building
import numpy as np
import pytest
from hand import FLOORS, trained
from images import Field, Patch, intact_image, program, program_input, results
from numpy.typing import NDArray

from firstcontact.contact import detect
from firstcontact.core import InputError
from firstcontact.export import USUAL_DIRECTIONS, Trained
from firstcontact.export import _c_library as c_library
from firstcontact.export._model_image import TEXT_MOST, model_image
from firstcontact.models import (
    ANY,
    LEVELS,
    CompactModel,
    CompactNetwork,
    Rig,
    compacted,
    cut_touches,
    pretrained,
)

FIRMWARE = Path(__file__).parents[2] / "firmware"
#: Extreme numbers of each type.
EXTREMES: dict[str, list[float]] = {
    "<f4": [np.nan, np.inf, -np.inf, 3.4e38, -3.4e38, 1e29, 1e20, 1e-45, 0.0, -1.0],
    "<f8": [np.nan, np.inf, -np.inf, 1.7e308, -1.7e308, 1e31, 1e-320, 0.0, -1.0],
    "<i4": [0, -1, 1, 2, 9, 75, 256, 1 << 16, 1 << 30, (1 << 31) - 1, -(1 << 31), 0x20000001],
    "<i2": [-32768, 32767, 0, -1],
}
TOO_LARGE = b"the model's numbers are too large"


@pytest.fixture(scope="module")
def intact(hand_models: tuple[Path, Path]) -> tuple[bytes, list[Field]]:
    return intact_image(hand_models[0])


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
    taken = records[records["why"] == b""]
    answered = taken["status"] == 0
    assert np.isin(taken["status"], (0, 1, 2)).all()
    low, value, high = (taken[name][answered] for name in ("low", "value", "high"))
    assert ((low >= 0) & (low <= value) & (value <= high) & (high <= 100)).all()


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
    request: pytest.FixtureRequest,
    strict: Path,
    intact: tuple[bytes, list[Field]],
    tmp_path: Path,
) -> None:
    if not building.has_emulator():
        pytest.skip(f"{request.node.name}: gcc-arm-none-eabi or qemu-system-arm is not installed")
    data, fields = intact
    patches = [Patch(len(data)), *(damaged(data, fields, seed) for seed in range(40))]
    native = building.ask_native(strict, program_input(data, patches), tmp_path)
    m7 = building.ask_m7(program().m7(tmp_path / "m7.elf"), program_input(data, patches), tmp_path)
    assert results(native)["why"][0] == b""
    assert (results(native)["status"][0] == 0).all()
    assert native == m7


def test_weights_that_would_overflow_are_refused(
    strict: Path, intact: tuple[bytes, list[Field]], tmp_path: Path
) -> None:
    """Each patch makes all floats of one array huge, so that rounding to 16 bits fails."""
    data, fields = intact
    floats = [f for f in fields if f.kind == "<f4" and f.count]
    huge = [Patch(len(data), (all_numbers(f, sign * 3.4e38),)) for f in floats for sign in (1, -1)]
    large = [Patch(len(data), (all_numbers(f, 1e6),)) for f in floats]
    records = results(building.ask_native(strict, program_input(data, huge + large), tmp_path))
    assert_sane(records)
    # Exceptions: whitening only enters a distance, and the bias of body1 belongs to the rig.
    assert (records["why"][: len(huge)] != b"").sum() >= len(huge) - 4
    assert (records["why"] == TOO_LARGE).any()
    assert (records["why"][len(huge) :] == b"").sum() > len(large) / 2


def test_text_that_would_damage_the_descriptor_is_refused(
    strict: Path, intact: tuple[bytes, list[Field]], tmp_path: Path
) -> None:
    data, _ = intact
    n = int.from_bytes(data[12:16], "little")
    ends = [
        (b'{"model":"', b'"}'),
        (b'{"model":"', b'"},"layout":{}'),
        (b'{"model":"', b'\x01"}'),
        (b'{"model":"', b'\xc3\xa4"}'),
        (b'{"model":"', b"}"),
        (b'{"model":"', b'\\"}'),
        (b'["', b'"]'),
        (b'{"a":{"', b'"}'),
    ]
    texts = [first + b"a" * (n - len(first) - len(last)) + last for first, last in ends]
    patches = [Patch(len(data), ((16, text),)) for text in texts]
    records = results(building.ask_native(strict, program_input(data, patches), tmp_path))
    refusal = b"the model's text cannot be told"
    assert records["why"].tolist() == [b"", *[refusal] * (len(ends) - 1)]


def overflowing(model: CompactModel, name: str) -> CompactModel:
    """Return the model with huge but finite scales in one thin layer."""
    network = model.network
    assert isinstance(network, CompactNetwork)
    thin = network.thin[name]
    scale = np.full_like(thin.into.scale, 3e38)
    layers = {**network.thin, name: replace(thin, into=replace(thin.into, scale=scale))}
    with pytest.raises(InputError, match="overflow"):
        CompactNetwork(network, layers)
    huge = CompactNetwork(network, network.thin)
    huge.thin = layers
    return CompactModel(huge, model.familiar, model.factors, model.level, model.rigs)


def test_host_refuses_the_same_models_as_the_device(tmp_path: Path) -> None:
    _, models = trained()
    assert models.detector is not None
    assert isinstance(models.anytime, CompactModel)
    for name in ("query1", "query2", "body1", "body2", "body3"):
        huge = overflowing(models.anytime, name)
        with pytest.raises(InputError, match="overflow"):
            model_image(models.detector, huge, FLOORS)
        with pytest.raises(InputError, match="overflow"):
            c_library.write(Trained(anytime=huge), tmp_path)
    assert not list(tmp_path.iterdir())
    models.detector.__class__.name, name = "x" * TEXT_MOST, models.detector.name
    try:
        with pytest.raises(InputError, match=r"\b38\d\b.*\b300\b"):
            model_image(models.detector, models.anytime, FLOORS)
    finally:
        models.detector.__class__.name = name


def test_default_image_fits_a_slot_and_the_docs_state_its_length() -> None:
    """The longest image has a rig for each finger and one for all, with the most levels."""
    pinches, models = trained()
    records = [next(iter(detect(models.detector, p)), None) for p in pinches.pinches]  # type: ignore[arg-type]
    touches, indices = cut_touches(pinches, records)
    header = (FIRMWARE / "answers/fc_store.h").read_text(encoding="utf-8")
    shift = re.search(r"FC_SLOT_BYTES = 1 << (\d+)", header)
    assert shift is not None
    page = (FIRMWARE.parent / "docs/reference/firmware.md").read_text(encoding="utf-8")
    lengths = []
    for fingers, levels in (((ANY,), 5), ((ANY, 0, 1), 5), ((ANY, 0, 1), LEVELS)):
        shore_a = 10.0 * (np.arange(len(indices)) % levels)
        rig = Rig.fit(touches, shore_a)
        network = pretrained().conditioned_on(dict.fromkeys(fingers, rig))
        model = compacted(network, touches, USUAL_DIRECTIONS)
        lengths.append(len(model_image(models.detector, model, FLOORS).data))  # type: ignore[arg-type]
    assert max(lengths) <= (1 << int(shift[1])) - 16
    row = " | ".join(f"{n:,}" for n in lengths)
    assert f"| {USUAL_DIRECTIONS} (default) | {row} |" in page
