"""Fixture: a device on its own port for each test."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from scripted_device import ScriptedDevice


@pytest.fixture
def device(tmp_path: Path) -> Iterator[ScriptedDevice]:
    with ScriptedDevice(tmp_path / "port") as device:
        yield device
