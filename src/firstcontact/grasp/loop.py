"""Grasp loop: it passes contacts and estimates to a policy, and the policy's commands on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import (
    ArgumentError,
    ChannelKind,
    Command,
    Contact,
    Estimate,
    Layout,
    Physical,
)
from firstcontact.core.text import summarize_error
from firstcontact.grasp.policy import Policy

#: Time at the start of a closing whose mean is the unloaded level of the force sensors, s.
REST = 0.05


@dataclass(slots=True)
class LoopCounts:
    """Counts of the closings, contacts, estimates and commands of a grasp loop.

    A withdrawn contact and its estimates only count in ``withdrawn``.
    """

    closings: int = 0
    #: Closings with a contact.
    contacts: int = 0
    commands: int = 0
    #: Contacts with an estimate that the policy acted on, and whose command reached the hand within
    #: the deadline and before the second contact.
    estimates: int = 0
    #: Contacts whose deadline passed without an estimate.
    misses: int = 0
    #: Estimates after the deadline or out of range, which the policy did not receive.
    unused: int = 0
    #: Contacts whose estimates met the deadline but reached the hand after the second contact.
    overtaken: int = 0
    withdrawn: int = 0


class GraspLoop:
    """Loop that passes events to a policy, and the policy's commands to a hand.

    All times are seconds on the clock of the samples. ``send`` returns False if it did not send the
    command. ``deadline`` is the time after a contact for its estimate, s, by default the policy's.
    ``wait`` returns the time until the hand accepts a command, s.
    """

    def __init__(
        self,
        policy: Policy,
        send: Callable[[Command], bool | None],
        rate: float,
        deadline: float | None = None,
        wait: Callable[[], float] = lambda: 0.0,
    ) -> None:
        self.policy = policy
        self.counts = LoopCounts()
        self._send = send
        self._rate = rate
        self._wait = wait
        default = policy.deadline
        self._deadline = default if deadline is None or default is None else deadline
        self._closing = self._holding = False
        self._last: Command | None = None
        self._first: float | None = None  # time of the first contact, s
        self._before = 0, 0  # misses and unused estimates before it
        self._due: float | None = None
        self._missed = False
        self._reached: list[float] = []  # times at which estimates reached the hand, s

    def begin(self) -> None:
        self.counts.closings += 1
        self._closing = True
        self._last = None
        self._forget_contact()
        self._act(self.policy.begin)

    def touched(self, contact: Contact, first: bool, now: float) -> None:
        if not self._closing:
            return
        if first:
            self.counts.contacts += 1
            self._before = self.counts.misses, self.counts.unused
            self._first = contact.sample / self._rate
            if self._deadline is not None:
                self._due = self._first + self._deadline
        self._act(self.policy.touched, contact, first)
        self._check_deadline(now)

    def withdrawn(self) -> None:
        """Continue the approach of the hand, because the detector withdrew the contact."""
        if not self._closing:
            return
        self.counts.withdrawn += 1
        if self._first is not None:
            self.counts.contacts -= 1
            self.counts.estimates -= bool(self._reached)
            self.counts.misses, self.counts.unused = self._before
        self._forget_contact()
        if self.policy.uses_piezos():  # other policies continue as before
            self._act(self.policy.begin)

    def estimated(self, estimate: Estimate, now: float) -> bool:
        """Pass an estimate that is available from ``now`` on. Return True if the policy used it."""
        reaches = now + self._wait()
        self._check_deadline(reaches)
        if not self._closing or self._first is None or self._missed:
            self.counts.unused += 1
            return False
        command = self._call_policy(self.policy.estimated, estimate)
        if command is None:  # the policy ignores this estimate and waits for another
            return False
        if not self._forward(command):
            return False
        self._due = None
        self.counts.estimates += not self._reached
        self._reached.append(reaches)
        return True

    def retract(self) -> None:
        """Send the policy's command without an estimate, because the newest one is invalid."""
        if self._closing and self._reached:
            self.counts.estimates -= 1
            self._reached = []
            if self._first is not None and self._deadline is not None:
                self._due = self._first + self._deadline
            self._act(self.policy.late)

    def felt(self, volts: float, now: float) -> None:
        """Pass the rise of the force sensors' voltage, V, to the policy.

        It also calls :meth:`Policy.late` if an estimate is overdue at ``now``.
        """
        if not self._closing:
            return
        since = None if self._first is None else now - self._first
        self._act(self.policy.felt, volts, since)
        self._check_deadline(now)

    def slipped(self, now: float) -> None:
        """Pass a slip to the policy, while the hand closes or holds the object."""
        if self._closing or self._holding:
            self._check_deadline(now)
            self._act(self.policy.slipped)

    def finish(self, second: Contact | None = None) -> bool:
        """End the closing.

        Return True if an estimate reached the hand before the second contact.
        """
        is_used = any(second is None or t < second.sample / self._rate for t in self._reached)
        is_late = bool(self._reached) and not is_used
        self.counts.estimates -= is_late
        self.counts.overtaken += is_late
        self._reached = []
        self.counts.misses += self._due is not None
        self._due = None
        self._holding, self._closing = self._closing, False
        return is_used

    def released(self) -> None:
        """Pass no more slips to the policy, because the hand has released the object."""
        self._holding = False

    def _forget_contact(self) -> None:
        self._first = self._due = None
        self._missed = False
        self._reached = []

    def _check_deadline(self, now: float) -> None:
        if self._due is not None and now > self._due:
            self._due = None
            self._missed = True
            self.counts.misses += 1
            self._act(self.policy.late)

    def _act(self, method: Callable[..., Command | None], *arguments: object) -> None:
        self._forward(self._call_policy(method, *arguments))

    def _call_policy(
        self, method: Callable[..., Command | None], *arguments: object
    ) -> Command | None:
        """Call a method of the policy, and return its command.

        Raise InputError with the policy's name if the method fails, or returns neither a command
        nor None.
        """
        name = self.policy.name
        try:
            command = method(*arguments)
        except Exception as error:
            raise ArgumentError(
                f"policy {name!r} raised {summarize_error(error)}: fix it or choose another policy",
                parameter="policy",
            ) from error
        if command is not None and not isinstance(command, Command):
            raise ArgumentError(
                f"policy {name!r} returned {type(command).__name__}: return a Command or None",
                parameter="policy",
            )
        return command

    def _forward(self, command: Command | None) -> bool:
        """Send a policy's command, unless it is None or equals the last one.

        Return False if the hand could not accept the command, else True.
        """
        if command is None or command == self._last:
            return True
        if self._send(command) is False:
            return False
        self._last = command
        self.counts.commands += 1
        return True


class Taxels:
    """Meter of the force cells (taxels): largest rise of a voltage above its unloaded level."""

    def __init__(self, layout: Layout) -> None:
        columns = layout.columns(ChannelKind.FORCE)
        self._physical = Physical(layout, columns)
        self._rest_samples = round(REST * layout.rate)
        self._sum = np.zeros(len(columns))
        self._count = 0

    def begin(self) -> None:
        """Start to measure the unloaded levels again. Call it while the hand is empty."""
        self._sum[:] = 0.0
        self._count = 0

    def update(self, data: NDArray[Any]) -> float:
        """Process raw samples. Return the largest rise at the last one, V.

        It is 0 while the unloaded levels are being measured.
        """
        if not self._sum.size or not len(data):
            return 0.0
        if self._count < self._rest_samples:
            volts = self._physical(data[: self._rest_samples - self._count])
            self._sum += volts.sum(axis=0)
            self._count += len(volts)
            if self._count < self._rest_samples:
                return 0.0
        return float((self._physical(data[-1:])[0] - self._sum / self._count).max())
