"""Tests of the model transfer: it is complete or refused, for any answers of the device."""

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import pytest
from model_taker import MODEL, TAKER, HostClock, ModelTaker, Says
from scripted_device import ScriptedDevice

from firstcontact.core import InputError
from firstcontact.device import flashing as flashing
from firstcontact.device.flashing import CHUNK, flash_model
from firstcontact.device.protocol import FrameType
from firstcontact.device.responder import Responder

DATA = bytes(range(256)) * 40


@pytest.fixture(autouse=True)
def clock(monkeypatch: pytest.MonkeyPatch) -> HostClock:
    clock = HostClock()
    monkeypatch.setattr(flashing, "time", clock)
    monkeypatch.setattr(flashing, "PATIENCE", 2 * flashing.REPEAT_AFTER)
    return clock


@contextmanager
def model_taker(path: Path, says: Says, clock: HostClock) -> Iterator[tuple[str, ModelTaker]]:
    """Run a device on a port. Yield the port and the device."""
    responder = partial(ModelTaker, says=says, clock=clock)
    with ScriptedDevice(path, descriptor=TAKER, responder=responder) as device:
        yield device.port, device.responder


def flash_error(path: Path, says: Says, clock: HostClock) -> tuple[str, int]:
    """Return the error of a transfer, and the number of pieces sent."""
    with model_taker(path, says, clock) as (port, taker):
        with pytest.raises(InputError) as error:
            flash_model(port, DATA)
        assert str(error.value).startswith(f"{port}: ")
        return str(error.value), taker.pieces


def test_model_is_flashed_in_chunks(tmp_path: Path, clock: HostClock) -> None:
    with model_taker(tmp_path / "port", lambda kind, stored: stored, clock) as (port, taker):
        assert flash_model(port, DATA) == MODEL
        assert taker.model == DATA
        assert taker.pieces == -(-len(DATA) // CHUNK)


@pytest.mark.parametrize("lost_answer", range(3))
def test_lost_answer_is_requested_again(tmp_path: Path, lost_answer: int, clock: HostClock) -> None:
    count = 0

    def answer(kind: FrameType, stored: int) -> int | None:
        nonlocal count
        count += 1
        return None if count == (1, 20, 2 + -(-len(DATA) // CHUNK))[lost_answer] else stored

    with model_taker(tmp_path / "port", answer, clock) as (port, taker):
        assert flash_model(port, DATA) == MODEL
        assert taker.model == DATA


@pytest.mark.parametrize("progress", [lambda turn: turn % 2 * CHUNK, lambda turn: turn])
def test_device_with_no_or_tiny_progress_is_refused(
    tmp_path: Path, clock: HostClock, progress: Callable[[int], int]
) -> None:
    turns = iter(range(10**6))
    sentence, pieces = flash_error(
        tmp_path / "port", lambda kind, stored: progress(next(turns)), clock
    )
    assert f"of {len(DATA)} bytes" in sentence
    assert pieces < 3 * len(DATA) / CHUNK


def test_device_without_models_is_refused(tmp_path: Path, clock: HostClock) -> None:
    class Plain(Responder):
        def handle(self, kind: int, payload: bytes) -> None:
            super().handle(kind, payload)
            if kind == FrameType.MODEL_BEGIN:
                clock.skip()

    with (
        ScriptedDevice(tmp_path / "port", responder=Plain) as device,
        pytest.raises(InputError, match=f"{re.escape(device.port)}: .*no models"),
    ):
        flash_model(device.port, DATA)


@pytest.mark.parametrize("reply", [b"", b"\0\x87", 2**32 - 1, len(DATA) + 1])
def test_invalid_answer_ends_the_transfer(
    tmp_path: Path, reply: int | bytes, clock: HostClock
) -> None:
    _, pieces = flash_error(
        tmp_path / "port",
        lambda kind, stored: reply if kind == FrameType.MODEL_CHUNK else stored,
        clock,
    )
    assert pieces <= 3
