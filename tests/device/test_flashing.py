"""Tests of the model transfer: complete or refused, for any answers of the device."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import pytest
from model_taker import MODEL, TAKER, ModelTaker, Says
from scripted_device import ScriptedDevice

from firstcontact.core import InputError
from firstcontact.device import FrameType, flash_model
from firstcontact.device import _flashing as flashing
from firstcontact.device._flashing import CHUNK, MOST_REPEATS

DATA = bytes(range(256)) * 40


@pytest.fixture(autouse=True)
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(flashing, "PATIENCE", 0.4)
    monkeypatch.setattr(flashing, "REPEAT_AFTER", 0.2)


@contextmanager
def taking(path: Path, says: Says) -> Iterator[tuple[str, ModelTaker]]:
    """Run a device on a port. Yield the port and the device."""
    with ScriptedDevice(path, descriptor=TAKER, responder=partial(ModelTaker, says=says)) as device:
        assert isinstance(device.responder, ModelTaker)
        yield device.port, device.responder


def refused(path: Path, says: Says) -> tuple[str, int]:
    """Return the error of a transfer, and the number of pieces sent."""
    with taking(path, says) as (port, taker):
        with pytest.raises(InputError) as error:
            flash_model(port, DATA, 1, 2)
        assert str(error.value).startswith(f"{port}: ")
        return str(error.value), taker.pieces


def test_a_device_that_takes_all_of_it_answers_with_it(tmp_path: Path) -> None:
    with taking(tmp_path / "port", lambda kind, there: there) as (port, taker):
        assert flash_model(port, DATA, 1, 2) == MODEL
        assert taker.model == DATA
        assert taker.pieces == -(-len(DATA) // CHUNK)


@pytest.mark.parametrize("lost", range(3))
def test_an_answer_that_is_lost_is_asked_for_again(tmp_path: Path, lost: int) -> None:
    asked = 0

    def says(kind: FrameType, there: int) -> int | None:
        nonlocal asked
        asked += 1
        return None if asked == (1, 20, 2 + -(-len(DATA) // CHUNK))[lost] else there

    with taking(tmp_path / "port", says) as (port, taker):
        assert flash_model(port, DATA, 1, 2) == MODEL
        assert taker.model == DATA


def test_a_device_that_goes_back_and_forth_is_not_served_for_ever(tmp_path: Path) -> None:
    turns = iter(range(10**6))
    sentence, pieces = refused(tmp_path / "port", lambda kind, there: next(turns) % 2 * CHUNK)
    assert f"{CHUNK} of {len(DATA)} bytes" in sentence
    assert pieces <= 2 * MOST_REPEATS


def test_a_device_that_takes_a_byte_at_a_time_is_not_served_for_ever(tmp_path: Path) -> None:
    turns = iter(range(10**6))
    _, pieces = refused(tmp_path / "port", lambda kind, there: next(turns))
    assert pieces <= 2 * (len(DATA) // CHUNK + MOST_REPEATS)


@pytest.mark.parametrize("until", [0, 5000])
def test_a_device_that_falls_silent_is_told_how_far_it_came(tmp_path: Path, until: int) -> None:
    sentence, _ = refused(tmp_path / "port", lambda kind, there: None if there > until else there)
    assert f"after {-(-until // CHUNK) * CHUNK} of {len(DATA)} bytes" in sentence
    assert "takes no models" not in sentence


def test_a_device_that_falls_silent_at_the_end_is_not_told_that_it_has_the_model(
    tmp_path: Path,
) -> None:
    says: Says = lambda kind, there: None if kind == FrameType.MODEL_END else there  # noqa: E731
    sentence, _ = refused(tmp_path / "port", says)
    assert f"after {len(DATA)} of {len(DATA)} bytes" in sentence


def test_a_device_that_does_not_know_models_takes_none(tmp_path: Path) -> None:
    with (
        ScriptedDevice(tmp_path / "port") as device,
        pytest.raises(InputError, match="no models"),
    ):
        flash_model(device.port, DATA, 1, 2)


def test_a_device_that_hangs_before_it_takes_a_model_is_not_told_that_it_takes_none(
    tmp_path: Path,
) -> None:
    heard = 0

    def first(data: bytes) -> bytes:
        nonlocal heard
        heard += 1
        return data if heard <= 2 else b""

    with ScriptedDevice(tmp_path / "port", descriptor=TAKER) as device:
        device.script.hears = first
        with pytest.raises(InputError, match="port") as refusal:
            flash_model(device.port, DATA, 1, 2)
    assert "no models" not in str(refusal.value)


@pytest.mark.parametrize("said", [b"", b"\0\x87", 2**32 - 1, len(DATA) + 1])
def test_an_answer_that_is_none_ends_it(tmp_path: Path, said: int | bytes) -> None:
    _, pieces = refused(
        tmp_path / "port", lambda kind, there: said if kind == FrameType.MODEL_CHUNK else there
    )
    assert pieces <= 3
