"""Models sent over the wire: stored completely or not at all, also after faults and power cuts."""

import re
import struct
import zlib
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from device_process import running
from hand import FLOORS
from serial_host import Host

from firstcontact.cli.main import main
from firstcontact.cli.verbs.ports import answer
from firstcontact.contact import make_detector
from firstcontact.core import InputError
from firstcontact.device import Descriptor, protocol
from firstcontact.device.flashing import CHUNK, check_model_fits, flash_model
from firstcontact.device.protocol import FrameType
from firstcontact.export.hand_image import HandImage, hand_image
from firstcontact.models import load_model
from firstcontact.models.model import shipped_model
from firstcontact.testing import closings

#: Version of the images that the firmware reads.
FORMAT = 4
#: First bytes of a slot that holds a model.
MAGIC = b"1CFS"


@pytest.fixture
def model_file(tmp_path: Path) -> tuple[str, str]:
    """Return the options of a device with a file for models."""
    return "--models", str(tmp_path / "models")


def descriptor(host: Host) -> Descriptor:
    return Descriptor.from_text(protocol.read_descriptor(host.hello().payload)[2])


def active_model(host: Host) -> str | None:
    """Return the digest of the device's active model."""
    predictor = descriptor(host).predictor
    return None if predictor is None else predictor.model


def state(host: Host, kind: FrameType, payload: bytes = b"") -> tuple[int, str]:
    host.send(kind, payload)
    answer = host.answer(FrameType.MODEL_STATE).payload
    return answer[0], answer[6:].decode()


def begin_transfer(host: Host, image: HandImage, form: int = FORMAT) -> tuple[int, str]:
    payload = struct.pack("<III", form, len(image.data), zlib.crc32(image.data))
    return state(host, FrameType.MODEL_BEGIN, payload)


def send_chunks(host: Host, data: bytes, most: int | None = None) -> None:
    host.port.timeout = 0.001  # the replies are short and many
    for at in range(0, len(data) if most is None else most, CHUNK):
        chunk = struct.pack("<I", at) + data[at : at + CHUNK]
        assert state(host, FrameType.MODEL_CHUNK, chunk)[0] == 0


def lose_power(
    program: Path, model_file: tuple[str, str], old: HandImage, new: HandImage, most: int
) -> None:
    with running(program, *model_file) as device, Host(device.path) as host:
        assert active_model(host) == old.digest
        assert begin_transfer(host, new) == (0, "")
        send_chunks(host, new.data, most)
        device.process.kill()
        device.process.wait()


def test_power_cut_leaves_the_old_model(
    program: Path, model_file: tuple[str, str], images: tuple[HandImage, HandImage]
) -> None:
    old, new = images
    with running(program, *model_file) as device:
        assert flash_model(device.path, old.data) == old.digest
    for most in (len(new.data) // 2, len(new.data)):  # the second: all chunks, but no end frame
        with pytest.raises(AssertionError, match=r"^$"):  # the device has ended
            lose_power(program, model_file, old, new, most)
    with running(program, *model_file) as device:
        with Host(device.path) as host:
            assert active_model(host) == old.digest
        assert flash_model(device.path, new.data) == new.digest
    with running(program, *model_file) as device, Host(device.path) as host:
        assert active_model(host) == new.digest


@dataclass(frozen=True)
class ModelFile:
    """File in which the device's program stores models: two slots, each with a head."""

    file: Path

    def slots(self) -> tuple[bytearray, bytearray]:
        data = bytearray(self.file.read_bytes())
        return data[: len(data) // 2], data[len(data) // 2 :]

    def write(self, *slots: bytes | bytearray) -> None:
        self.file.write_bytes(b"".join(slots))

    def turn(self, slot: bytes) -> int:
        return struct.unpack_from("<I", slot, 4)[0] if slot[:4] == MAGIC else -1


def test_previous_model_is_active_if_the_newest_does_not_fit(
    strict_program: Path,
    model_file: tuple[str, str],
    images: tuple[HandImage, HandImage],
    capsys: pytest.CaptureFixture[str],
) -> None:
    """The newer slot is intact, but the firmware after an update reads another version."""
    old, new = images
    with running(strict_program, *model_file) as device:
        for image in images:
            flash_model(device.path, image.data)
    file = ModelFile(Path(model_file[1]))
    slots = sorted(file.slots(), key=file.turn)
    length = struct.unpack_from("<IIII", slots[1])[2]
    slots[1][16 + 4] ^= 1  # the version in the image
    struct.pack_into("<I", slots[1], 12, zlib.crc32(slots[1][16 : 16 + length]))
    file.write(*slots)
    with running(strict_program, *model_file) as device:
        with Host(device.path) as host:
            assert active_model(host) == old.digest
            models = descriptor(host).model_slot
            assert "version" in models.fault
        assert any("runs the one before it" in line for line in answer(device.path))
        assert main(["live", "--device", device.path, "--seconds", "0.2"]) == 0
        assert "cannot use the newest model" in capsys.readouterr().err
        # The next model replaces the one that does not fit.
        assert flash_model(device.path, new.data) == new.digest
    with running(strict_program, *model_file) as device, Host(device.path) as host:
        assert active_model(host) == new.digest
        models = descriptor(host).model_slot
        assert models.fault == ""
    assert old.data in bytes(b"".join(file.slots()))


def test_another_format_and_damage_are_refused(
    strict_program: Path, model_file: tuple[str, str], images: tuple[HandImage, HandImage]
) -> None:
    old, new = images
    other = new.data[:4] + struct.pack("<I", FORMAT + 1) + new.data[8:]
    with running(strict_program, *model_file) as device:
        flash_model(device.path, old.data)
        with Host(device.path) as host:
            assert "format" in begin_transfer(host, new, FORMAT + 1)[1]
            assert begin_transfer(host, new)[0] == 0
            assert "not whole" in state(host, FrameType.MODEL_END)[1]
            send_chunks(host, new.data[:-1] + bytes([new.data[-1] ^ 1]))
            assert "CRC" in state(host, FrameType.MODEL_END)[1]
            assert active_model(host) == old.digest
        with pytest.raises(InputError, match=f"{re.escape(device.path)}: .*format"):
            flash_model(device.path, other)


def test_invalid_numbers_are_refused_before_use(
    strict_program: Path, model_file: tuple[str, str], images: tuple[HandImage, HandImage]
) -> None:
    """Any bytes with the right CRC are refused or accepted, without undefined behaviour."""
    rng = np.random.default_rng(1)
    image = images[0]
    with running(strict_program, *model_file) as device, Host(device.path) as host:
        for _ in range(3):
            data = bytearray(image.data)
            for place in rng.integers(0, 1200, 3):  # the range of counts and sizes
                data[place] = int(rng.integers(256))
            damaged = HandImage(bytes(data), image.digest)
            assert begin_transfer(host, damaged)[0] == 0
            send_chunks(host, damaged.data)
            assert state(host, FrameType.MODEL_END)[0] in (1, 2)
        cut = HandImage(image.data[:5000], image.digest)
        assert begin_transfer(host, cut)[0] == 0
        send_chunks(host, cut.data)
        assert "not complete" in state(host, FrameType.MODEL_END)[1]


def test_model_is_refused_while_samples_are_sent(
    strict_program: Path, model_file: tuple[str, str], images: tuple[HandImage, HandImage]
) -> None:
    with running(strict_program, *model_file) as device, Host(device.path) as host:
        host.send(FrameType.START)
        assert begin_transfer(host, images[0]) == (2, "samples are being sent: stop them first")


def test_device_without_room_for_models_ignores_them(
    strict_program: Path, images: tuple[HandImage, HandImage]
) -> None:
    with running(strict_program) as device, Host(device.path) as host:
        host.send(FrameType.MODEL_END)
        assert active_model(host) is None
        host.assert_all_frames()


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Write the shipped model as a folder of `adapt`."""
    place = tmp_path_factory.mktemp("shipped") / "model"
    shipped_model().write(place)
    return place


def test_verb_flashes_the_model_and_prints_its_digest(
    program: Path,
    model_file: tuple[str, str],
    folder: Path,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
) -> None:
    from firstcontact.core.calibration import write_calibration

    write_calibration(FLOORS, tmp_path / "calibration.json")
    options = ["--calibration", str(tmp_path / "calibration.json")]
    with running(program, *model_file) as device:
        assert main(["flash-model", str(folder), "--device", device.path, *options]) == 0
    assert hand_image(folder).digest in capsys.readouterr().out
    assert main(["flash-model", str(tmp_path), "--device", "nowhere", *options]) == 2
    assert str(tmp_path) in capsys.readouterr().err


def test_device_without_models_is_refused_before_the_measurement(
    program: Path, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with running(program) as device:
        assert main(["flash-model", str(folder), "--device", device.path]) == 2
    printed = capsys.readouterr()
    assert "takes no models" in printed.err
    assert "measuring" not in printed.out


def test_models_that_a_hand_cannot_run_are_named(folder: Path, tmp_path: Path) -> None:
    model = load_model(folder)
    replace(model, predictors=()).write(tmp_path / "detector")
    with pytest.raises(InputError, match="no predictor"):
        hand_image(tmp_path / "detector")
    other = make_detector("svm").fit(closings(12))
    replace(model, detector=other).write(tmp_path / "svm")
    with pytest.raises(InputError, match="svm"):
        hand_image(tmp_path / "svm")


def test_too_large_model_is_refused_before_it_is_sent(
    program: Path, model_file: tuple[str, str], images: tuple[HandImage, HandImage]
) -> None:
    data = images[0].data
    with running(program, *model_file) as device:
        check_model_fits(device.path, data)
        with pytest.raises(InputError, match=str(1 << 20)):
            check_model_fits(device.path, data.ljust(1 << 20, b"-"))
        with pytest.raises(InputError, match=f"format .*{FORMAT + 1}"):
            check_model_fits(device.path, data[:4] + struct.pack("<I", FORMAT + 1) + data[8:])
