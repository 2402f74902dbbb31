"""Emulated Ability Hand at the other end of a pseudo terminal.

It uses the functions of the hand's own package. The simulated hand of that package has no port,
touch sensors or watchdog. They are added here as the hand's documents describe them, with an object
between the fingers.
"""

from __future__ import annotations

import select
import struct
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Self

from firstcontact.device.ports import PseudoTerminal
from firstcontact.grasp.ability import NEARLY_OPEN, SENSORS
from firstcontact.grasp.ability_package import load

#: Of a machine that does much else at the same time, s.
PATIENCE = 60.0

#: Time without a command after which the hand leaves the control of the port, s.
WATCHDOG = 0.3

#: Fastest a finger goes, degrees/s.
FASTEST = 400.0

#: Resolution of a reported position, degrees.
RESOLUTION = 150 / 32767
#: Step of a reported speed, degrees/s, and speed of a rotor as a multiple of its finger's speed.
SPEED_STEP, ROTOR = 3000 / 32767 / 4, 0.4


class EmulatedAbility:
    """Emulated hand with an object between its fingers.

    Parameters
    ----------
    port
        Name of the pseudo terminal.
    touch_at
        Flexion at which finger and thumb meet the object, degrees.
    stiffness
        Stiffness of the object, N per degree.
    """

    def __init__(self, port: Path, touch_at: float = 1e3, stiffness: float = 0.2) -> None:
        load()
        from ah_wrapper.functions import compute_chksum
        from ah_wrapper.ppp_stuffing import PPPUnstuff, ppp_stuff
        from ah_wrapper.sim_functions import GeneratedPacket

        self._stuffed = lambda body: ppp_stuff(bytearray([*body, compute_chksum(list(body))]))
        self._packet = GeneratedPacket
        self._unstuffer = PPPUnstuff()
        self._terminal = PseudoTerminal(port)
        self._touch_at, self._stiffness = touch_at, stiffness
        self.position = [30.0, 30.0, 30.0, 30.0, 30.0, -30.0]
        self.speed = [0.0] * 6
        self.targets: list[list[float]] = []
        self.hardest = 0.0
        self.controlled = False
        self.mute = False
        self._told = 0.0
        self._change = threading.Condition()
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._run)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *exception: object) -> None:
        self._ending.set()
        self._thread.join()
        self._terminal.unplug()

    def wait(self, reached: Callable[[EmulatedAbility], bool]) -> None:
        """Wait until the hand meets a condition."""
        with self._change:
            assert self._change.wait_for(lambda: reached(self), PATIENCE), self.position

    @property
    def open(self) -> bool:
        """Return True if the hand reports finger and thumb as open."""
        return max(self.position[0], self.position[4]) < NEARLY_OPEN + RESOLUTION

    def force(self, motor: int) -> float:
        """Force of a fingertip, N."""
        return max(self.position[motor] - self._touch_at, 0.0) * self._stiffness

    def unplug(self) -> None:
        """Unplug the cable."""
        self._ending.set()
        self._thread.join()
        self._terminal.unplug()

    def _run(self) -> None:
        while not self._ending.is_set():
            ready, _, _ = select.select([self._terminal], [], [], 0.05)
            with self._change:
                if ready:
                    for byte in self._terminal.read():
                        if frame := self._unstuffer.unstuff_byte(byte):
                            self._take(bytes(frame))
                if self.controlled and time.monotonic() > self._told + WATCHDOG:
                    self.controlled = False
                self._change.notify_all()

    def _take(self, frame: bytes) -> None:
        assert sum(frame) & 0xFF == 0, "checksum"
        if frame[1] == 0xA2:
            self._terminal.write(bytes(self._packet(pos=self.position, reply_mode=2).packet))
            return
        assert frame[1] == 0x11, "positions, with speeds and touch in the answer"
        targets = [x * RESOLUTION for x in struct.unpack("<6h", frame[2:14])]
        now = time.monotonic()
        far = FASTEST * (now - self._told)
        self._told, self.controlled = now, True
        self.targets.append(targets)
        pairs = zip(self.position, targets, strict=True)
        moves = [min(max(to - at, -far), far) for at, to in pairs]
        self.position = [at + move for at, move in zip(self.position, moves, strict=True)]
        self.speed = [ROTOR * move * FASTEST / far for move in moves]
        self.hardest = max(self.hardest, self.force(0), self.force(4))
        if not self.mute:
            self._terminal.write(bytes(self._stuffed(self._answer())))

    def _answer(self) -> bytes:
        raw = [0] * 30
        for motor, first in SENSORS.items():
            raw[first + 1] = _count(self.force(motor))
        body = bytes([0x11])
        for at, speed in zip(self.position, self.speed, strict=True):
            body += struct.pack("<hh", int(at / RESOLUTION), int(speed / SPEED_STEP))
        for low, high in zip(raw[::2], raw[1::2], strict=True):
            body += (low | high << 12).to_bytes(3, "little")
        return body + bytes(1)


def _count(force: float) -> int:
    """Return the converter value of a touch sensor at a force."""
    if force <= 0.88:
        return 0
    resistance = 121591.0 / (force - 0.878894)
    return min(int(33000.0 / (3.3 / 4096) / max(resistance - 10000.0, 1.0)), 4095)
