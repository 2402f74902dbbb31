"""Gate of the firmware compared with the host's: the same closings, with and without gaps."""

from __future__ import annotations

import ctypes
import subprocess
from functools import cache

import numpy as np
import pytest
from firmware_build import FIRMWARE
from hand import FLOORS

from firstcontact.chain import Chain, EventKind, build_image
from firstcontact.core import Block, ChannelKind, Finger, fingertip_layout
from firstcontact.twin import DeviceFilter, TwinStream

LAYOUT = fingertip_layout()
#: Memory for a gate, more than it needs, bytes.
ROOM = 4096


@cache
def samples() -> np.ndarray:
    return DeviceFilter().update(TwinStream(seed=4).read(12 * 4936))


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    made = tmp_path_factory.mktemp("gate") / "gate.so"
    source = FIRMWARE / "answers" / "fc_gate.c"
    kernels = FIRMWARE.parent / "src" / "firstcontact" / "export" / "c"
    options = ["-std=c99", "-O2", "-ffp-contract=off", "-shared", "-fPIC", f"-I{kernels}"]
    subprocess.run(["gcc", *options, str(source), "-o", str(made)], check=True)
    return ctypes.CDLL(str(made))


def volts(kind: ChannelKind) -> np.ndarray:
    columns = LAYOUT.columns(kind)
    return np.ascontiguousarray(LAYOUT.physical(samples(), columns), np.float64)


def of_firmware(library: ctypes.CDLL, cut: int, lost: int) -> list[tuple[str, int]]:
    """Return when the firmware's gate opens and shuts.

    From ``cut`` on, ``lost`` samples are missing.
    """
    gate = ctypes.create_string_buffer(ROOM)
    floors = (ctypes.c_double * 2)(*(FLOORS.noise(f) or 0.0 for f in Finger))
    piezo, loads = volts(ChannelKind.VIBRATION), volts(ChannelKind.FORCE)
    library.fc_gate_start(gate, floors, ctypes.c_uint32(0))
    turns = []
    for n in [*range(cut), *range(cut + lost, len(samples()))]:
        if lost and n == cut + lost:
            library.fc_gate_start(gate, floors, ctypes.c_uint32(n))
        at = (a[n].ctypes.data_as(ctypes.c_void_p) for a in (piezo, loads))
        turn = library.fc_gate_take(gate, *at)
        turns += [("opens" if turn == 1 else "shuts", n + 1)] if turn else []
    return turns


def of_host(cut: int, lost: int) -> list[tuple[str, int]]:
    gate = Chain(build_image(LAYOUT.rate), LAYOUT, FLOORS)
    events = gate.take(Block(samples()[:cut]))
    events += gate.take(Block(samples()[cut + lost :], cut + lost))
    names = {EventKind.CLOSING_BEGAN: "opens", EventKind.CLOSING_ENDED: "shuts"}
    named = [(names[EventKind(e.kind)], e.sample) for e in events]
    # The firmware's gate does not report that a gap ends a closing: its caller restarts it.
    return [e for e in named if not lost or e != ("shuts", cut)]


@pytest.mark.parametrize("lost", [0, 1, 7, 15, 44])
def test_closings_equal_the_hosts(library: ctypes.CDLL, lost: int) -> None:
    first = next(n for turn, n in of_host(0, 0) if turn == "opens")
    turns = of_firmware(library, first + 23, lost)
    assert len(turns) > 4
    assert turns == of_host(first + 23, lost)
