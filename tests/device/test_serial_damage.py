"""Tests of a line that flips, cuts or repeats bytes."""

from __future__ import annotations

import os
from collections.abc import Callable

import pytest
from scripted_device import ScriptedDevice, collect
from serial_faults import every_other

from firstcontact.device import SerialSource


@pytest.mark.parametrize(
    ("change", "bad"),
    [
        (lambda f: f[:20] + bytes([f[20] ^ 1]) + f[21:], 1),
        (lambda f: f[:20] + b"\x55" + f[20:], 1),
        (lambda f: f[:20] + f[21:], 1),
        (lambda f: f[:20] + b"\0" + f[21:], 2),
        (lambda f: os.urandom(1000).replace(b"\0", b"\1") + b"\0", 1),
        (lambda f: b"", 0),
    ],
    ids=["flipped", "inserted", "deleted", "cut", "burst", "gone"],
)
def test_damage_loses_only_its_frames(
    device: ScriptedDevice, change: Callable[[bytes], bytes], bad: int
) -> None:
    device.script.sends = every_other(10, change)
    with SerialSource(device.port) as source:
        device.put(5005)  # 1001 frames, of which 100 are damaged
        collect(source, lambda n: n == 5005 - 500)
    health = source.health
    assert health.lost_frames == 100
    assert health.lost_samples == 500
    assert health.samples == 4505
    assert health.bad_frames == 100 * bad


def test_doubled_frames_are_dropped(device: ScriptedDevice) -> None:
    device.script.sends = every_other(10, lambda frame: frame + frame)
    with SerialSource(device.port) as source:
        device.put(5000)
        collect(source, lambda n: n == 5000)
    assert source.health.doubled_frames == 100
    assert source.health.lost_frames == 0
