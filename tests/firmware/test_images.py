"""What comes as a model may be anything: it is refused, or answers, and nothing is undefined."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import building
import numpy as np
import pytest
from hand import FLOORS, trained
from images import Field, Patch, asked, fields_of, program, tried
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
    pretrained,
    touches_of,
)

FIRMWARE = Path(__file__).parents[2] / "firmware"
#: Numbers at the edges of their kind.
NASTY: dict[str, list[float]] = {
    "<f4": [np.nan, np.inf, -np.inf, 3.4e38, -3.4e38, 1e29, 1e20, 1e-45, 0.0, -1.0],
    "<f8": [np.nan, np.inf, -np.inf, 1.7e308, -1.7e308, 1e31, 1e-320, 0.0, -1.0],
    "<i4": [0, -1, 1, 2, 9, 75, 256, 1 << 16, 1 << 30, (1 << 31) - 1, -(1 << 31), 0x20000001],
    "<i2": [-32768, 32767, 0, -1],
}
TOO_LARGE = b"the model's numbers are too large"


@pytest.fixture(scope="module")
def sound(hand_models: tuple[Path, Path]) -> tuple[bytes, list[Field]]:
    return fields_of(hand_models[0])


@pytest.fixture(scope="module")
def strict(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """It dies of the first thing that is undefined, or of a byte outside of the image."""
    return program().native(tmp_path_factory.mktemp("images") / "strict", strict=True)


def number(field: Field, value: float, k: int = 0) -> tuple[int, bytes]:
    """One number of a field, as a patch has it."""
    return field.at + k * field.size, np.array(value).astype(field.kind).tobytes()


def whole(field: Field, value: float) -> tuple[int, bytes]:
    return field.at, np.full(field.count, value).astype(field.kind).tobytes()


def spoilt(data: bytes, fields: list[Field], seed: int) -> Patch:
    """One image of many kinds of damage."""
    rng = np.random.default_rng(seed)
    kind = rng.integers(5)
    if kind == 0:  # cut
        return Patch(int(rng.integers(len(data))) + 1)
    if kind == 1:  # bytes near the front, where lengths are, or anywhere
        most = len(data) if rng.random() < 0.5 else 1200
        places = rng.integers(0, most, rng.integers(1, 8)).tolist()
        return Patch(len(data), tuple((p, bytes([rng.integers(256)])) for p in places))
    if kind == 2:  # counts alone
        counts = [f for f in fields if f.kind == "<i4"]
        chosen = [counts[k] for k in rng.integers(0, len(counts), rng.integers(1, 3))]
    else:
        chosen = [fields[k] for k in rng.integers(0, len(fields), rng.integers(1, 4))]
    made = whole if kind == 3 else lambda f, v: number(f, v, int(rng.integers(f.count)))
    full = [f for f in chosen if f.count]
    return Patch(len(data), tuple(made(f, float(rng.choice(NASTY[f.kind]))) for f in full))


def assert_sane(found: NDArray[np.void]) -> None:
    taken = found[found["why"] == b""]
    answered = taken["status"] == 0
    assert np.isin(taken["status"], (0, 1, 2)).all()
    low, value, high = (taken[name][answered] for name in ("low", "value", "high"))
    assert ((low >= 0) & (low <= value) & (value <= high) & (high <= 100)).all()


def fuzzed(
    strict: Path, sound: tuple[bytes, list[Field]], seeds: range, folder: Path
) -> NDArray[np.void]:
    data, fields = sound
    patches = [spoilt(data, fields, seed) for seed in seeds]
    found = tried(building.ask_native(strict, asked(data, patches), folder))
    assert len(found) == len(patches)
    assert_sane(found)
    cut = np.array([patch.length < len(data) for patch in patches])
    assert (found["why"][cut] != b"").all()
    return found


def test_spoilt_images_are_refused_or_answer(
    strict: Path, sound: tuple[bytes, list[Field]], tmp_path: Path
) -> None:
    found = fuzzed(strict, sound, range(300), tmp_path)
    assert 20 < (found["why"] == b"").sum() < 280
    assert len(set(found["why"].tolist())) > 4


@pytest.mark.slow
def test_a_hundred_thousand_spoilt_images_are_refused_or_answer(
    strict: Path, sound: tuple[bytes, list[Field]], tmp_path: Path
) -> None:
    for first in range(1000, 101_000, 5000):
        fuzzed(strict, sound, range(first, first + 5000), tmp_path)


def test_the_board_says_of_each_what_this_machine_says(
    request: pytest.FixtureRequest,
    strict: Path,
    sound: tuple[bytes, list[Field]],
    tmp_path: Path,
) -> None:
    if not building.emulator_there():
        pytest.skip(f"{request.node.name}: gcc-arm-none-eabi or qemu-system-arm is not installed")
    data, fields = sound
    patches = [Patch(len(data)), *(spoilt(data, fields, seed) for seed in range(40))]
    native = building.ask_native(strict, asked(data, patches), tmp_path)
    m7 = building.ask_m7(program().m7(tmp_path / "m7.elf"), asked(data, patches), tmp_path)
    assert tried(native)["why"][0] == b""
    assert (tried(native)["status"][0] == 0).all()
    assert native == m7


def test_weights_that_would_overflow_are_refused_and_those_below_answer(
    strict: Path, sound: tuple[bytes, list[Field]], tmp_path: Path
) -> None:
    """What cannot be rounded to 16 bits never comes up: all floats of an array huge at once."""
    data, fields = sound
    floats = [f for f in fields if f.kind == "<f4" and f.count]
    huge = [Patch(len(data), (whole(f, way * 3.4e38),)) for f in floats for way in (1, -1)]
    large = [Patch(len(data), (whole(f, 1e6),)) for f in floats]
    found = tried(building.ask_native(strict, asked(data, huge + large), tmp_path))
    assert_sane(found)
    # Whitening goes into a distance and no further; a bias of body1 is the rig's.
    assert (found["why"][: len(huge)] != b"").sum() >= len(huge) - 4
    assert (found["why"] == TOO_LARGE).any()
    assert (found["why"][len(huge) :] == b"").sum() > len(large) / 2


def test_a_text_that_would_spoil_the_descriptor_is_refused(
    strict: Path, sound: tuple[bytes, list[Field]], tmp_path: Path
) -> None:
    data, _ = sound
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
    found = tried(
        building.ask_native(
            strict, asked(data, [Patch(len(data), ((16, text),)) for text in texts]), tmp_path
        )
    )
    told = b"the model's text cannot be told"
    assert found["why"].tolist() == [b"", *[told] * (len(ends) - 1)]


def overflowing(model: CompactModel, name: str) -> CompactModel:
    """The same with one thin layer whose scales are huge, and finite."""
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


def test_the_host_refuses_what_the_hand_would(tmp_path: Path) -> None:
    _, known = trained()
    assert known.detector is not None
    assert isinstance(known.anytime, CompactModel)
    for name in ("query1", "query2", "body1", "body2", "body3"):
        huge = overflowing(known.anytime, name)
        with pytest.raises(InputError, match="overflow"):
            model_image(known.detector, huge, FLOORS)
        with pytest.raises(InputError, match="overflow"):
            c_library.write(Trained(anytime=huge), tmp_path)
    assert not list(tmp_path.iterdir())
    known.detector.__class__.name, name = "x" * TEXT_MOST, known.detector.name
    try:
        with pytest.raises(InputError, match=r"takes 38\d bytes .* room for 300"):
            model_image(known.detector, known.anytime, FLOORS)
    finally:
        known.detector.__class__.name = name


def test_what_is_written_by_default_fits_a_place_and_the_docs_say_how_long_it_is() -> None:
    """The longest: a rig for each finger and for any other, with as many levels as there may be."""
    pinches, known = trained()
    found = [next(iter(detect(known.detector, p)), None) for p in pinches.pinches]  # type: ignore[arg-type]
    touches, which = touches_of(pinches, found)
    header = (FIRMWARE / "answers/fc_store.h").read_text(encoding="utf-8")
    shift = re.search(r"FC_SLOT_BYTES = 1 << (\d+)", header)
    assert shift is not None
    page = (FIRMWARE.parent / "docs/reference/firmware.md").read_text(encoding="utf-8")
    lengths = []
    for fingers, levels in (((ANY,), 5), ((ANY, 0, 1), 5), ((ANY, 0, 1), LEVELS)):
        shore_a = 10.0 * (np.arange(len(which)) % levels)
        rig = Rig.of(touches, shore_a)
        told = pretrained().told_of(dict.fromkeys(fingers, rig))
        model = compacted(told, touches, USUAL_DIRECTIONS)
        lengths.append(len(model_image(known.detector, model, FLOORS).data))  # type: ignore[arg-type]
    assert max(lengths) <= (1 << int(shift[1])) - 16
    row = " | ".join(f"{n:,}" for n in lengths)
    assert f"| {USUAL_DIRECTIONS} (default) | {row} |" in page
