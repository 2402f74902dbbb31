"""Driver of PSYONIC's Ability Hand, which uses the package of its maker.

The lever arms come from the hand's URDF (size "large"). docs/reference/hands.md states their error.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from math import degrees, inf, nan, radians
from typing import Any, Self

from firstcontact.core import Command
from firstcontact.grasp.ability_package import SIMULATED, check, claimed, open_client
from firstcontact.grasp.hand import Begins, Hand, HandError, HandLimits

INDEX, MIDDLE, RING, PINKY, THUMB, ROTATOR = range(6)
#: Travel of the pad per radian of the finger's joint, m. URDF: index 0.105 (open) to 0.073
#: (80 degrees), here at 45 degrees; thumb 0.052 (pad) to 0.059 (tip).
LEVERS = {INDEX: 0.092, THUMB: 0.055}
#: Index of a finger's first touch sensor. A finger has six, the hand thirty.
SENSORS = {INDEX: 0, THUMB: 24}
#: Flexion of an open and of a fully closed finger, degrees.
OPEN, CLOSED = 5.0, 100.0
#: Rotation of the thumb opposite the index finger, degrees; assumed.
OPPOSED = -80.0
#: Targets of the six motors that open the hand, degrees.
RELEASED = [OPEN] * 5 + [OPPOSED]
#: Largest lead of a target over a closing finger, degrees; assumed. It limits the force of the
#: hand's position controller when no touch sensor reports the contact.
LEAD = 10.0
#: Largest flexion of a finger that counts as open, degrees.
NEARLY_OPEN = OPEN + 3.0
#: Longest time for which one step of the targets makes up, s.
STEP = 0.03
#: Time without an answer after which the hand counts as lost, s.
LOST = 0.5
#: Rate of commands and reports, Hz: the default of the maker's package, for every baud rate of the
#: hand.
RATE = 500.0
#: Number of past positions that are kept in memory: those of 0.5 s.
REMEMBERED = int(RATE / 2)
#: Reply of the hand with positions, rotor velocities and touch.
REPLY_MODE = 1
#: Longest wait for the hand to report that it is open, s.
OPENING = 2.0


@dataclass(frozen=True, slots=True)
class Felt:
    """Last report of the Ability Hand: angles, speeds and forces of its fingers."""

    position: Sequence[float]
    touch: Sequence[float] = ()
    velocity: Sequence[float] = ()

    def force(self, finger: int) -> float:
        """Return the sum of the forces on a finger's six sensors, N; 0 without sensors."""
        first = SENSORS[finger]
        return sum(max(x, 0.0) for x in self.touch[first : first + 6])

    @property
    def travel(self) -> float:
        """Distance of the fingertips from the joints' zero, m: mean of index finger and thumb."""
        return _mean_of_pads(self.position)

    @property
    def speed(self) -> float:
        """Mean speed of both fingertips, in a unit of the hand's motors; NaN if not reported."""
        return _mean_of_pads(self.velocity) if self.velocity else nan

    @property
    def open(self) -> bool:
        """True if index finger and thumb are open."""
        return all(self.position[finger] <= NEARLY_OPEN for finger in LEVERS)


def _mean_of_pads(of_joints: Sequence[float]) -> float:
    return sum(radians(of_joints[f]) * lever for f, lever in LEVERS.items()) / len(LEVERS)


class Fingers:
    """Target angles of all joints, degrees. Commands move those of index finger and thumb."""

    def __init__(self, felt: Felt) -> None:
        self._targets = {finger: _within(felt.position[finger]) for finger in LEVERS}

    @property
    def targets(self) -> list[float]:
        index = self._targets[INDEX]
        return [index, index, index, index, self._targets[THUMB], OPPOSED]

    def open(self) -> None:
        self._targets = dict.fromkeys(self._targets, OPEN)

    def move(self, command: Command, seconds: float, felt: Felt) -> None:
        """Move the target angles at the commanded speed for ``seconds`` s.

        The angles of a finger stop once it is pressed as hard as the command allows.
        """
        for finger, lever in LEVERS.items():
            target, position = self._targets[finger], felt.position[finger]
            pressed = command.speed >= 0 and felt.force(finger) >= command.force
            if pressed:
                target = min(target, position)
            else:
                target += degrees(command.speed / lever) * seconds
                if command.speed > 0:
                    target = min(target, position + LEAD)
            self._targets[finger] = _within(target)


def _within(flexion: float) -> float:
    return min(max(flexion, OPEN), CLOSED)


class AbilityHand(Hand):
    """Driver of the Ability Hand. Its index finger and thumb close at the commanded speed."""

    name = "ability"
    limits = HandLimits(speed=0.25, force=10.0, rate=RATE, watchdog=0.3)
    simulated_port = SIMULATED
    begins = Begins.US
    position_rate = limits.rate

    def __init__(self, port: str | None = None) -> None:
        self._port = check(port)
        self._change = threading.Condition()
        self._thread: threading.Thread | None = None
        self._ready = threading.Event()
        self._closing = False
        self._command: Command | None = None
        self._heard = 0.0
        self._failure: Exception | None = None
        self._felt: Felt | None = None
        self._unloaded: list[float] = []  # forces of the first report
        self._positions: deque[tuple[float, ...]] = deque(maxlen=REMEMBERED)

    @property
    def felt(self) -> Felt | None:
        return self._felt

    def positions(self) -> Sequence[tuple[float, ...]]:
        return list(self._positions)

    def send(self, command: Command) -> None:
        """Send a command. The hand follows it until the next command, but for at most 0.3 s."""
        with self._change:
            if self._thread is None or self._closing:
                raise HandError(f"the hand {self.name!r} is not open: use it in a with block")
            if self._failure is not None:
                raise HandError(str(self._failure)) from self._failure
            self._command, self._heard = command, time.monotonic()
            self._change.notify()

    def release(self) -> None:
        """Open the hand at its highest speed, and keep it open until the next command."""
        with self._change:
            self._command = None
            self._change.notify()

    def close(self) -> None:
        """Open the hand, wait up to 2 s until it reports that it is open, and close the port."""
        with self._change:
            self._closing, self._command = True, None
            self._change.notify()
        if self._thread is not None:
            self._thread.join()

    def __enter__(self) -> Self:
        # A daemon thread, and so is the package's reading thread. A program that ends without
        # closing stops sending, and the hand's own watchdog opens it.
        self._thread = threading.Thread(target=self._run, name="ability hand", daemon=True)
        self._thread.start()
        self._ready.wait()
        if self._failure is not None:
            self.close()
            raise self._failure
        return self

    def _run(self) -> None:
        try:
            with claimed(self._port):
                client = open_client(self._port, self.limits.rate)
                self._ready.set()
                try:
                    self._drive(client)
                finally:
                    client.close()
        except Exception as error:
            self._failure = error
        finally:
            self._ready.set()

    def _drive(self, client: Any) -> None:
        """Send target angles and read the hand's reports, until :meth:`close` is called.

        Then open the hand. Return once it reports that it is open, or after :data:`OPENING` s.
        """
        fingers: Fingers | None = None
        targets, self._unloaded = list[float](), []
        now = moved = answered = time.monotonic()
        reads, until = client.n_reads, inf
        while True:
            now, command, is_closing = self._next_step(now)
            if is_closing and until == inf:
                until = now + OPENING
            fresh = client.n_reads != reads and client.hand.get_position() is not None
            if fresh:
                reads, answered = client.n_reads, now
                felt = self._take_report(client.hand, now)
                fingers = fingers or Fingers(felt)
            elif now > answered + LOST and self._failure is None:
                self._failure = HandError(f"the Ability Hand on {self._port} stopped answering")
            # Use the reported position only if the hand reported it after the order to open.
            opened = fresh and targets == RELEASED and self._felt is not None and self._felt.open
            if now >= until or (until < inf and opened):
                return
            targets = RELEASED
            if fingers is not None and self._felt is not None:
                if command is None or self._failure is not None:
                    fingers.open()
                    moved = now
                elif fresh:
                    # Each step needs an answer to the previous one. After a stall the finger
                    # continues from its present position.
                    fingers.move(command, min(now - moved, STEP), self._felt)
                    moved = now
                targets = fingers.targets
            client.set_position(targets, reply_mode=REPLY_MODE)
            client.send_command()

    def _next_step(self, last: float) -> tuple[float, Command | None, bool]:
        """Wait for the next step of the drive loop. ``last`` is the time of the last step, s.

        Return the time of this step, s, the command to follow (None to open the hand), and True if
        :meth:`close` was called.
        """
        with self._change:
            self._change.wait(max(last + 1 / self.limits.rate - time.monotonic(), 0.0))
            now = time.monotonic()
            if self._command is not None and now > self._heard + self.limits.watchdog:
                self._command = None
            return now, self._command, self._closing

    def _take_report(self, hand: Any, now: float) -> Felt:
        """Store the newest report of the hand, which came at the time ``now``, s. Return it.

        The forces are relative to those of the first report.
        """
        touch = hand.get_fsr() or []
        self._unloaded = self._unloaded or touch
        above = [x - z for x, z in zip(touch, self._unloaded, strict=True)]
        self._felt = Felt(hand.get_position(), above, hand.get_velocity() or ())
        self._positions.append((now, self._felt.travel, self._felt.speed))
        return self._felt
