"""Models over the wire: kept whole or not at all, whatever comes and whenever the power goes."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import numpy as np
import pytest
from device_process import running
from hand import FLOORS
from serial_host import Host

from firstcontact.cli.main import main
from firstcontact.core import InputError
from firstcontact.device import Descriptor, protocol
from firstcontact.device.flashing import CHUNK, flash_model
from firstcontact.device.protocol import FrameType
from firstcontact.embedded.hand_model import hand_image
from firstcontact.embedded.model_image import FORMAT, ModelImage


@pytest.fixture
def kept(tmp_path: Path) -> tuple[str, str]:
    """Options of a device with a file for models."""
    return "--models", str(tmp_path / "models")


@pytest.fixture
def images(hand_models: tuple[Path, Path]) -> tuple[ModelImage, ModelImage]:
    first, second = (hand_image(folder, FLOORS) for folder in hand_models)
    assert first.digest != second.digest
    return first, second


def answering(host: Host) -> str | None:
    """Digest of the model that a device says it answers with."""
    answers = Descriptor.from_text(protocol.read_descriptor(host.hello().payload)[2]).answers
    return None if answers is None else answers.model


def state(host: Host, kind: FrameType, payload: bytes = b"") -> tuple[int, str]:
    host.send(kind, payload)
    answer = host.answer(FrameType.MODEL_STATE).payload
    return answer[0], answer[6:].decode()


def begun(host: Host, image: ModelImage, form: int = FORMAT) -> tuple[int, str]:
    told = struct.pack("<IIII", form, image.sizes, len(image.data), zlib.crc32(image.data))
    return state(host, FrameType.MODEL_BEGIN, told)


def sent(host: Host, data: bytes, most: int | None = None) -> None:
    host.port.timeout = 0.001  # answers are short, and there are many
    for at in range(0, len(data) if most is None else most, CHUNK):
        chunk = struct.pack("<I", at) + data[at : at + CHUNK]
        assert state(host, FrameType.MODEL_CHUNK, chunk)[0] == 0


def lose_power(
    program: Path, kept: tuple[str, str], old: ModelImage, new: ModelImage, most: int
) -> None:
    with running(program, *kept) as device, Host(device.path) as host:
        assert answering(host) == old.digest
        assert begun(host, new) == (0, "")
        sent(host, new.data, most)
        device.process.kill()
        device.process.wait()


def test_power_that_goes_in_the_middle_leaves_the_old_model(
    program: Path, kept: tuple[str, str], images: tuple[ModelImage, ModelImage]
) -> None:
    old, new = images
    with running(program, *kept) as device:
        assert flash_model(device.path, old.data, FORMAT, old.sizes) == old.digest
    for most in (len(new.data) // 2, len(new.data)):  # the last one: all but the word to keep it
        with pytest.raises(AssertionError, match=r"^$"):  # a device that died
            lose_power(program, kept, old, new, most)
    with running(program, *kept) as device:
        with Host(device.path) as host:
            assert answering(host) == old.digest
        assert flash_model(device.path, new.data, FORMAT, new.sizes) == new.digest
    with running(program, *kept) as device, Host(device.path) as host:
        assert answering(host) == new.digest


def test_another_format_other_sizes_and_damage_are_refused(
    strict_program: Path, kept: tuple[str, str], images: tuple[ModelImage, ModelImage]
) -> None:
    old, new = images
    other = ModelImage(new.data, new.sizes ^ 1, new.digest)
    with running(strict_program, *kept) as device:
        flash_model(device.path, old.data, FORMAT, old.sizes)
        with Host(device.path) as host:
            assert "format" in begun(host, new, FORMAT + 1)[1]
            assert "sizes" in begun(host, other)[1]
            assert begun(host, new)[0] == 0
            assert "not whole" in state(host, FrameType.MODEL_END)[1]
            sent(host, new.data[:-1] + bytes([new.data[-1] ^ 1]))
            assert "CRC" in state(host, FrameType.MODEL_END)[1]
            assert answering(host) == old.digest
        with pytest.raises(InputError, match=r"other sizes .* keeps its old one"):
            flash_model(device.path, new.data, FORMAT, other.sizes)


def test_numbers_that_do_not_fit_are_refused_before_they_are_used(
    strict_program: Path, kept: tuple[str, str], images: tuple[ModelImage, ModelImage]
) -> None:
    """Whatever the bytes, with the right CRC: refused, or taken, and nothing undefined happens."""
    rng = np.random.default_rng(1)
    image = images[0]
    with running(strict_program, *kept) as device, Host(device.path) as host:
        for _ in range(3):
            data = bytearray(image.data)
            for place in rng.integers(0, 1200, 3):  # where counts and sizes are
                data[place] = int(rng.integers(256))
            spoilt = ModelImage(bytes(data), image.sizes, image.digest)
            assert begun(host, spoilt)[0] == 0
            sent(host, spoilt.data)
            assert state(host, FrameType.MODEL_END)[0] in (1, 2)
        cut = ModelImage(image.data[:5000], image.sizes, image.digest)
        assert begun(host, cut)[0] == 0
        sent(host, cut.data)
        assert "not whole" in state(host, FrameType.MODEL_END)[1]


def test_no_model_is_taken_while_samples_are_sent(
    strict_program: Path, kept: tuple[str, str], images: tuple[ModelImage, ModelImage]
) -> None:
    with running(strict_program, *kept) as device, Host(device.path) as host:
        host.send(FrameType.START)
        assert begun(host, images[0]) == (2, "samples are being sent: stop them first")


def test_a_device_without_room_for_models_takes_no_notice(
    strict_program: Path, images: tuple[ModelImage, ModelImage]
) -> None:
    with running(strict_program) as device, Host(device.path) as host:
        host.send(FrameType.MODEL_END)
        assert answering(host) is None
        host.assert_every_frame_arrived()


def test_the_verb_flashes_and_says_what_answers(
    program: Path,
    kept: tuple[str, str],
    hand_models: tuple[Path, Path],
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
) -> None:
    from firstcontact.core.calibration_file import write_calibration

    write_calibration(FLOORS, tmp_path / "calibration.json")
    told = ["--calibration", str(tmp_path / "calibration.json")]
    with running(program, *kept) as device:
        assert main(["flash-model", str(hand_models[0]), "--device", device.path, *told]) == 0
    assert hand_image(hand_models[0]).digest in capsys.readouterr().out
    assert main(["flash-model", str(tmp_path), "--device", "nowhere", *told]) == 2
    assert "export-model" in capsys.readouterr().err
