"""Tests of opening a source by its name."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from compiled_kernels import using
from firstcontact.core import InputError
from firstcontact.device import SerialSource, open_source
from firstcontact.device._twin_source import TwinSource


def test_port_name_opens_a_serial_source() -> None:
    source = open_source("/dev/ttyACM0")
    assert isinstance(source, SerialSource)
    assert source.name == "/dev/ttyACM0"


def test_path_opens_like_its_name() -> None:
    source = open_source(Path("/dev/ttyACM0"))
    assert isinstance(source, SerialSource)
    assert source.name == "/dev/ttyACM0"


def test_speed_of_a_real_device_is_refused() -> None:
    with pytest.raises(InputError, match=r"--speed .*/dev/ttyACM0"):
        open_source("/dev/ttyACM0", speed=2.0)


@pytest.mark.parametrize("speed", [1.0, math.inf])
def test_folder_is_refused_at_any_speed(tmp_path: Path, speed: float) -> None:
    with pytest.raises(InputError, match=r"\*\.mcap"):
        open_source(str(tmp_path), speed=speed)


def test_twin_opens_by_name() -> None:
    with open_source("twin", speed=10.0, condition="everyday", seed=3) as source:
        assert isinstance(source, TwinSource)
        assert source.descriptor.source == "twin"
        assert source.read(60.0)


def test_unknown_condition_is_refused_on_opening() -> None:
    with pytest.raises(InputError, match="condition 'lab'"):
        open_source("twin", condition="lab").__enter__()


def test_a_twin_without_compiled_code_is_refused() -> None:
    with using("nothing compiled"), pytest.raises(InputError, match="nothing compiled"):
        open_source("twin")
