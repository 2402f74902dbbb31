"""Live events to a grasp policy, and its commands to a hand."""

from __future__ import annotations

from collections.abc import Sequence

from firstcontact.contact import SlipDetector
from firstcontact.core import Block, Command, Layout
from firstcontact.device import TransportDelay
from firstcontact.grasp import Begins, GraspLoop, Hand, Policy, SafeHand, Stiffness, Taxels
from firstcontact.streaming._events import (
    Armed,
    Estimated,
    Event,
    HandAsked,
    PinchDone,
    Running,
    Settled,
    Touched,
)
from firstcontact.streaming._hand_requests import Ask, HandRequests

#: Who opened a hand that was released because samples, or this program, were silent.
SILENCE = "silence"


class Grasping:
    """Drives a hand through the closings of a live session; an actor of it.

    A closing that others begin is heard (:class:`Armed`). One that is
    ours begins when it is asked for and goes on, or is held, until the hand is asked to open, is
    released because of a silence, or whoever asked is gone; of such a hand the motor's start alone
    begins nothing: it may be that of its opening.

    Where an any-time model answers, the policy is told the one answer that stands, and estimates
    of fixed windows are left aside; one that is out of range counts as none.

    Times are those of the samples. Where an estimate is told, the deadline is held against the time
    at which the hand gets it: with the computing, with how much later the samples came than those
    that came soonest, and with the hand's pacing. The shortest way through the cable is not known.

    Parameters
    ----------
    policy
        What decides.
    hand
        Open. A :class:`~firstcontact.grasp._safe.SafeHand` is told with every block that
        the session lives.
    layout
        Of the samples.
    deadline
        For an estimate, s after the first contact; None takes the policy's own.
    slip
        Tells the policy of slips, in closings that are ours, from their end on until the hand
        opens; None where nothing does.
    transport
        Follows the samples' delay where they come as fast as they are taken; None where not.
    """

    def __init__(
        self,
        policy: Policy,
        hand: Hand,
        layout: Layout,
        deadline: float | None = None,
        transport: TransportDelay | None = None,
        slip: SlipDetector | None = None,
    ) -> None:
        self.hand = hand
        wait = (lambda: hand.wait) if isinstance(hand, SafeHand) else (lambda: 0.0)
        self.loop = GraspLoop(policy, self._send, layout.rate, deadline, wait)
        #: What viewers and the keyboard ask of the hand.
        self.requests = HandRequests(hand.name, hand.begins, hand.release)
        #: What the hand was told last, None before the first.
        self.last: Command | None = None
        self._taxels = Taxels(layout)
        self._rate = layout.rate
        self._transport = transport
        self._slip = slip
        #: Slips that the policy was told of.
        self.slips = 0
        if slip is not None:
            slip.start(layout)
        self._late = 0.0  # how much later the newest samples came than the soonest, s
        self._epoch = 0
        self._done = True
        self._running = self._settled = False
        self._released = 0

    def arrived(self, block: Block, host: float) -> None:
        """Samples came at a time of the host's clock; what is found in them is told next."""
        if self._transport is not None:
            self._transport.add(block, host)
            self._late = self._transport.of(block.end - 1, host)

    def happened(self, event: Event) -> None:
        """Let the policy answer to an event."""
        match event:
            case Armed():
                self._armed(event)
            case Touched():
                self.loop.touched(event.contact, event.first, event.contact.decided / self._rate)
            case Running():
                self._running = True
            case Settled():
                self._stands(event)
            case Estimated() if self._running:
                pass  # what stands of the any-time model was told, or will be
            case Estimated() if event.used:
                now = event.contact.sample / self._rate + event.after(self._rate)
                self.loop.estimated(
                    Stiffness(event.value, event.low, event.high, event.duration), now
                )
            case Estimated():
                self.loop.counts.unused += 1
            case PinchDone():
                self._done = True
                self._hold()
                self.loop.done(event.contacts[1] if len(event.contacts) > 1 else None)

    def came(self, block: Block) -> Sequence[Event]:
        """Let the policy feel the force, and see the time pass; obey who asked for something.

        Returns
        -------
        sequence of Event
            What became of the hand, where somebody asked or it was released.
        """
        told = self._obey(block)
        if isinstance(self.hand, SafeHand):
            self.hand.alive()
        if not self._done and block.epoch == self._epoch:
            volts = self._taxels.update(block.data)
            self.loop.felt(volts, block.end / self._rate + self._late)
        if self._slip is not None and self._slip.update(block):
            self.slips += 1
            self.loop.slipped(block.end / self._rate + self._late)
        return told

    def ended(self) -> None:
        """Let go, before anything slower is closed."""
        self.requests.end()
        self.hand.release()

    def _armed(self, event: Armed) -> None:
        """The motor is heard: a closing of others begins, or ours is on its way."""
        ours = self.requests.by is not None
        if not ours and Begins.OTHERS not in self.hand.begins:
            return
        self._epoch = event.epoch
        self._taxels.begin()
        if not ours:
            self._begin()

    def _begin(self) -> None:
        self._done = False
        self._running = self._settled = False
        if self._slip is not None:
            self._slip.release()
        self.loop.begin()

    def _hold(self) -> None:
        # When others open a hand is not known: the motor would be taken for a slip, and held on to.
        if self._slip is not None and self.requests.by is not None:
            self._slip.hold()

    def _obey(self, block: Block) -> list[Event]:
        """Do what was asked since the last block."""
        told: list[Event] = []
        by = self.requests.by
        while request := self.requests.take():
            if request.ask is Ask.CLOSE:
                if self.requests.by is None:
                    self.requests.by = request.by
                    self._epoch, self._released = block.epoch, self._releases
                    self._taxels.begin()
                    self._begin()
                    told.append(HandAsked(Ask.CLOSE, request.by, block.end - 1, block.epoch))
                continue
            if request.ask is Ask.OPEN or request.by == self.requests.by:
                self._open()
                told.append(HandAsked(Ask.OPEN, request.by, block.end - 1, block.epoch))
            self.requests.opening = False
        if by is not None and self.requests.by is not None and self._releases != self._released:
            self._open()
            told.append(HandAsked(Ask.OPEN, SILENCE, block.end - 1, block.epoch))
        return told

    def _open(self) -> None:
        """The closing is over, whoever began it, and the hand released."""
        self.requests.by = None
        self._done = True
        self.loop.done()
        self.loop.released()
        if self._slip is not None:
            self._slip.release()
        self.hand.release()

    @property
    def _releases(self) -> int:
        return self.hand.counts.released if isinstance(self.hand, SafeHand) else 0

    def _stands(self, event: Settled) -> None:
        """Tell what stands, once: a hand that acted on it cannot take that back."""
        answer = event.answer
        if self._settled or answer is None:
            return
        self._settled = True
        if answer.strange:  # its interval may not hold: as if there were no estimate
            self.loop.counts.unused += 1
            return
        later = (event.complete - answer.complete) / self._rate
        now = answer.contact.sample / self._rate + answer.after(self._rate) + later
        now += self._late - answer.transport  # it is told with this block, not with its own
        told = Stiffness(answer.value, answer.low, answer.high, answer.duration, standing=True)
        self.loop.estimated(told, now)

    def _send(self, command: Command) -> None:
        if self.requests.opening:
            return
        self.last = command
        self.hand.send(command)
        if self._done:  # the motor that obeys is as loud as a slip
            self._hold()


def grasp_lines(grasping: Grasping, *, real_time: bool = True) -> list[str]:
    """What the hand was told, for the end of a run.

    Without ``real_time`` it leaves out what met the time limit: that means nothing where samples
    come faster than they were taken.
    """
    counts = grasping.loop.counts
    lines = [
        f"hand {grasping.hand.name} with policy {grasping.loop.policy.name}: "
        f"{counts.commands} commands in {counts.closings} closings, "
        f"{counts.contacts} of these with a contact"
    ]
    if real_time:
        lines.append(
            f"{counts.estimates} estimates reached the hand within the policy's time limit and "
            f"before the second contact; {counts.overtaken} within the limit, but after the second "
            f"contact; {counts.misses} contacts had none within the limit; {counts.unused} "
            "estimates were not used: past the limit, or out of range"
        )
    if grasping.slips:
        lines.append(f"{grasping.slips} slips heard, or said to go on")
    if isinstance(grasping.hand, SafeHand):
        c = grasping.hand.counts
        lines.append(
            f"{c.sent} commands went to the hand, and {c.repeated} repeats that kept it from "
            f"timing out; {c.superseded} were not sent, since a newer one or a release came first; "
            f"{c.clipped} asked for more than the hand can do and were reduced to that; the hand "
            f"was released {c.released} times"
        )
    return lines
