"""Tests of the twin on its terminal."""

import os
import select
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from twin_host import host

from firstcontact.core import InputError
from firstcontact.device.ports import LinkError
from firstcontact.device.protocol import FrameType
from firstcontact.device.twin_process import TwinOptions
from firstcontact.device.twin_source import TwinDevice
from firstcontact.twin import TwinStream
from processes import gone, stop


@pytest.fixture
def twin() -> Iterator[TwinDevice]:
    with TwinDevice(TwinOptions(seed=4, speed=20)) as device:
        yield device


def test_real_time_samples_and_markers_equal_the_stream() -> None:
    with TwinDevice(TwinOptions(seed=4)) as device, host(device.port) as h:
        h.start(4 * 4936)
        end = h.stop()
        stream = TwinStream(seed=4)
        stream.read(end)
        words = [(p.start, f"twin: {p.label.object}") for p in stream.pinches]
        words += [(p.end, f"twin: peak {p.peak:.1f} N") for p in stream.pinches if p.end]
        first = h.blocks[0].first_sample
        assert h.markers == sorted(w for w in words if first <= w[0] < end)
        assert len(h.markers) >= 3


def test_accelerated_twin_waits_for_a_stalled_host(twin: TwinDevice) -> None:
    with host(twin.port) as h:
        h.start(1000)
        # 20 s of the twin's time: far more than fits into the line and what waits for it.
        select.select([], [], [], 1.0)
        h.start(8 * 4936)
        h.stop()
        assert h.assembler.counts.overflow_samples == 0


def test_stalled_host_losses_are_counted_in_real_time() -> None:
    with TwinDevice(TwinOptions(seed=4)) as twin, host(twin.port) as h:
        h.start(1000)
        # Looks elsewhere for longer than the device can keep.
        select.select([], [], [], 1.5)
        h.listen(lambda: h.assembler.counts.overflow_samples)
        h.stop()


def test_replugged_cable_restores_the_port_name(twin: TwinDevice) -> None:
    with host(twin.port) as h:
        h.start(500)
        end = h.assembler.next_sample
        twin.unplug()
        assert not Path(twin.port).exists()
        with pytest.raises(LinkError):
            h.say(FrameType.STOP)
        twin.unplug()
    twin.plug()
    twin.plug()
    with host(twin.port) as h:
        h.start(500)
        assert h.blocks[0].first_sample > end


def test_ctrl_c_does_not_reach_the_twin(twin: TwinDevice) -> None:
    assert os.getsid(twin.pid) != os.getsid(0), "not in the group that the terminal signals"
    os.kill(twin.pid, signal.SIGINT)
    with host(twin.port):
        pass


PARENT = """
import sys
from firstcontact.device.twin_process import TwinOptions
from firstcontact.device.twin_source import TwinDevice
device = TwinDevice(TwinOptions())
print(device.pid, device.port, flush=True)
sys.stdin.read()
"""


def test_twin_dies_with_a_killed_parent() -> None:
    pipe = subprocess.PIPE
    with subprocess.Popen([sys.executable, "-c", PARENT], stdin=pipe, stdout=pipe) as parent:
        pid, port = parent.stdout.readline().split()
        assert Path(port.decode()).exists()
        # Suspended, so that it cannot end by itself when its input closes, just before the signal.
        os.kill(int(pid), signal.SIGSTOP)
        parent.kill()
    assert gone(int(pid))


def test_suspended_twin_is_closed() -> None:
    device = TwinDevice(TwinOptions(speed=20))
    stop(device.pid)
    device.close()
    assert gone(device.pid)
    assert not Path(device.port).parent.exists()


def test_closed_twin_has_ended() -> None:
    twin = TwinDevice(TwinOptions(speed=20))
    twin.close()
    twin.close()
    assert gone(twin.pid)
    assert not Path(twin.port).exists()
    with pytest.raises(InputError):
        twin.unplug()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"condition": "lab"}, "condition 'lab'"),
        ({"objects": ["pear"]}, "object 'pear'"),
        ({"seed": -1}, "seed"),
        ({"speed": 0.0}, "speed"),
        ({"speed": float("inf")}, "speed"),
        ({"latency": -1.0}, "latency"),
        ({"speed": float("nan")}, "speed"),
    ],
)
def test_invalid_arguments_are_refused(arguments: dict[str, object], words: str) -> None:
    with pytest.raises(InputError, match=words):
        TwinDevice(TwinOptions(**arguments))  # type: ignore[arg-type]
