"""From what happens to what the hand is told, with every missed deadline counted."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from firstcontact.core import Command, Contact, InputError
from firstcontact.grasp._policy import Policy, Stiffness


@dataclass(slots=True)
class LoopCounts:
    """What happened so far.

    Parameters
    ----------
    closings, contacts
        Closings, and those of them with a contact.
    commands
        Sent.
    estimates
        That reached the hand within the deadline of their closing and, in hindsight, before
        the second contact.
    misses
        Contacts whose deadline passed without an estimate.
    unused
        Estimates that came after it and were not acted upon.
    overtaken
        Estimates within the deadline that, in hindsight, reached the hand after the second contact.
    """

    closings: int = 0
    contacts: int = 0
    commands: int = 0
    estimates: int = 0
    misses: int = 0
    unused: int = 0
    overtaken: int = 0


class GraspLoop:
    """Asks a policy and tells a hand.

    All times are seconds of one clock that only goes forward, that of the samples: sample
    number over rate, plus what was spent on the way and on computing. An estimate that reaches
    the hand at the deadline itself meets it. After a miss the fallback holds for the rest of
    the closing.

    Parameters
    ----------
    policy
        What decides.
    send
        Takes a command to the hand; None is never sent, and the same command not twice.
    rate
        Of the samples, Hz.
    deadline
        After the first contact, s; None takes the policy's own.
    wait
        How long a command that is given now waits until the hand takes it, s.
    """

    def __init__(
        self,
        policy: Policy,
        send: Callable[[Command], None],
        rate: float,
        deadline: float | None = None,
        wait: Callable[[], float] = lambda: 0.0,
    ) -> None:
        self.policy = policy
        self.counts = LoopCounts()
        self._send = send
        self._rate = rate
        self._wait = wait
        self._reached: list[float] = []
        wants = policy.deadline
        self._patience = deadline if deadline is not None and wants is not None else wants
        self._closing = self._holding = False
        self._first: float | None = None
        self._due: float | None = None
        self._missed = False
        self._last: Command | None = None

    def begin(self) -> None:
        """A closing begins."""
        self.counts.closings += 1
        self._closing = True
        self._first = self._due = self._last = None
        self._missed = False
        self._reached = []
        self._tell(self.policy.begin())

    def touched(self, contact: Contact, first: bool, now: float) -> None:
        """A finger touched, as was known at ``now``."""
        if not self._closing:
            return
        if first:
            self.counts.contacts += 1
            self._first = contact.sample / self._rate
            if self._patience is not None:
                self._due = self._first + self._patience
        self._tell(self.policy.touched(contact, first))
        self._watch(now)

    def estimated(self, stiffness: Stiffness, now: float) -> None:
        """An estimate came at ``now``."""
        reaches = now + self._wait()
        self._watch(reaches)
        if not self._closing or self._first is None or self._missed:
            self.counts.unused += 1
            return
        self.counts.estimates += 1
        self._reached.append(reaches)
        # Whoever passes this one over still waits for another.
        command = self.policy.estimated(stiffness)
        if command is not None:
            self._due = None
        self._tell(command)

    def felt(self, volts: float, now: float) -> None:
        """A block of samples up to ``now`` was felt; comes with every block, as time does."""
        if not self._closing:
            return
        since = None if self._first is None else now - self._first
        self._tell(self.policy.felt(volts, since))
        self._watch(now)

    def slipped(self, now: float) -> None:
        """The object slips, as was known at ``now``: also after the closing, while it is held."""
        if self._closing or self._holding:
            self._watch(now)
            self._tell(self.policy.slipped())

    def done(self, second: Contact | None = None) -> None:
        """The closing is over: what was waited for was missed, and nobody is told any more.

        Parameters
        ----------
        second
            The second contact: estimates that reached the hand after it do not count.
        """
        late = 0 if second is None else sum(t >= second.sample / self._rate for t in self._reached)
        self.counts.estimates -= late
        self.counts.overtaken += late
        self._reached = []
        self.counts.misses += self._due is not None
        self._due = None
        self._holding = self._closing
        self._closing = False

    def released(self) -> None:
        """The hand has let go: nobody is told of a slip any more."""
        self._holding = False

    def _watch(self, now: float) -> None:
        if self._due is not None and now > self._due:
            self._miss()

    def _miss(self) -> None:
        self._due = None
        self._missed = True
        self.counts.misses += 1
        self._tell(self.policy.late())

    def _tell(self, command: Command | None) -> None:
        if command is None:
            return
        if not isinstance(command, Command):
            raise InputError(
                f"policy {self.policy.name!r} returned {type(command).__name__}: let it return a "
                "Command or None"
            )
        if command == self._last:
            return
        self._last = command
        self.counts.commands += 1
        self._send(command)
