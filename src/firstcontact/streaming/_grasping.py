"""Bridge from live events to a grasp policy, and from its commands to a hand."""

from __future__ import annotations

from collections.abc import Sequence

from firstcontact.contact import SlipDetector
from firstcontact.core import Block, Command, Estimate, Layout, counted
from firstcontact.device import TransportDelay
from firstcontact.grasp import Begins, GraspLoop, Hand, Policy, SafeHand, Taxels
from firstcontact.streaming._events import (
    ClosingStart,
    ContactEvent,
    ContactWithdrawn,
    Event,
    HandCommand,
    PinchDone,
)
from firstcontact.streaming._hand_requests import Ask, HandRequests

#: Name of the origin of a release that follows a silence of the samples or of this program.
SILENCE = "silence"


class Grasping:
    """Event handler that drives a hand through the closings of a live session.

    Some hands close by themselves: the start of the motor (:class:`ClosingStart`) begins their
    closings. Other hands close on request. Their motor's start alone begins no closing, because the
    motor may also open the hand. A requested closing ends with a request to open, or when the
    origin of the request disconnects. It also ends with a release because samples stopped coming or
    this program paused.

    The policy gets the final estimate of a closing. A policy with ``early`` also gets the estimates
    before the final one. Estimates out of range are ignored.

    Times are on the samples' clock. An estimate meets the deadline if it reaches the hand before
    the deadline. The time to reach the hand includes computing and the hand's pacing. It also
    includes the transport of the samples, except for the shortest transport time, which is unknown.

    Parameters
    ----------
    policy
        Grasp policy.
    hand
        Hand with an open connection. Each block restarts the timeout after which a
        :class:`~firstcontact.grasp.SafeHand` releases the hand.
    layout
        Columns of the samples.
    deadline
        Deadline of an estimate, s after the first contact; by default that of the policy.
    transport
        Measurement of the samples' delay if they come in real time; None otherwise.
    slip
        Slip detector for requested closings, from their end until the hand opens. None means that
        slips are not detected.
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
        #: Requests of viewers and the keyboard.
        self.requests = HandRequests(hand.name, hand.begins, hand.release)
        #: Last command, None before the first.
        self.last: Command | None = None
        self._taxels = Taxels(layout)
        self._rate = layout.rate
        self._transport = transport
        self._slip = slip
        #: Number of slips so far.
        self.slips = 0
        if slip is not None:
            slip.start(layout)
        self._late = 0.0  # delay of the newest samples beyond the least delayed ones, s
        self._epoch = 0
        self._done = True
        self._is_final = False
        self._acted_on = -1.0  # elapsed time of the estimate that the policy acted on, s
        self._second: int | None = None  # sample with which the second contact was decided
        self._released = 0

    def on_samples(self, block: Block, host: float) -> None:
        """Process new samples before their events."""
        if self._transport is not None:
            self._transport.add(block, host)
            self._late = self._transport.delay(block.end - 1, host)

    def on_event(self, event: Event) -> None:
        """Pass an event to the policy."""
        match event:
            case ClosingStart():
                self._closing_starts(event)
            case ContactEvent():
                if not event.first:
                    self._second = event.contact.decided
                self.loop.touched(event.contact, event.first, event.contact.decided / self._rate)
            case ContactWithdrawn():
                self._is_final, self._acted_on, self._second = False, -1.0, None
                self.loop.withdrawn()
            case Estimate():
                self._estimated(event)
            case PinchDone():
                self._done = True
                self._hold()
                self.loop.finish(event.second)

    def after_block(self, block: Block) -> Sequence[Event]:
        """Pass force and time to the policy, and carry out requests.

        Returns
        -------
        sequence of Event
            One event for each request that was carried out. One more for a release because samples
            stopped coming or this program paused.
        """
        events = self._obey(block)
        if isinstance(self.hand, SafeHand):
            self.hand.alive()
        if not self._done and block.epoch == self._epoch:
            volts = self._taxels.update(block.data)
            self.loop.felt(volts, block.end / self._rate + self._late)
        if self._slip is not None and self._slip.update(block):
            self.slips += 1
            self.loop.slipped(block.end / self._rate + self._late)
        return events

    def ended(self) -> None:
        """Release the hand before the source and the outputs are closed, which takes longer."""
        self.requests.end()
        self.hand.release()

    def _closing_starts(self, event: ClosingStart) -> None:
        """Process the start of the motor: begin a closing if the hand closes by itself."""
        is_requested = self.requests.by is not None
        if not is_requested and Begins.OTHERS not in self.hand.begins:
            return
        self._epoch = event.epoch
        self._taxels.begin()
        if not is_requested:
            self._begin()

    def _begin(self) -> None:
        self._done = False
        self._is_final = False
        self._acted_on = -1.0
        self._second = None
        if self._slip is not None:
            self._slip.release()
        self.loop.begin()

    def _hold(self) -> None:
        # A hand that opens by itself does not say so: its motor would pass for a slip.
        if self._slip is not None and self.requests.by is not None:
            self._slip.hold()

    def _obey(self, block: Block) -> list[Event]:
        """Carry out the requests since the last block."""
        events: list[Event] = []
        by = self.requests.by
        while request := self.requests.take():
            if request.ask is Ask.CLOSE:
                if Begins.HURRY in self.hand.begins:
                    self.hand.start()  # the start of its motor then begins the closing
                    events.append(HandCommand(Ask.CLOSE, request.by, block.end - 1, block.epoch))
                elif self.requests.by is None:
                    self.requests.by = request.by
                    self._epoch, self._released = block.epoch, self._releases
                    self._taxels.begin()
                    self._begin()
                    events.append(HandCommand(Ask.CLOSE, request.by, block.end - 1, block.epoch))
                continue
            if self.requests.opens(request):
                self._open()
                events.append(HandCommand(Ask.OPEN, request.by, block.end - 1, block.epoch))
        if by is not None and self.requests.by is not None and self._releases != self._released:
            self._open()
            events.append(HandCommand(Ask.OPEN, SILENCE, block.end - 1, block.epoch))
        return events

    def _open(self) -> None:
        """End the closing and release the hand."""
        self.requests.by = None
        self._done = True
        self.loop.finish()
        self.loop.released()
        if self._slip is not None:
            self._slip.release()
        self.hand.release()

    @property
    def _releases(self) -> int:
        return self.hand.counts.released if isinstance(self.hand, SafeHand) else 0

    def _estimated(self, estimate: Estimate) -> None:
        """Pass an estimate to the policy. The final estimate is passed once at most."""
        if self._is_final or not (estimate.final or self.loop.policy.early):
            return
        self._is_final = estimate.final
        if estimate.final and estimate.elapsed == self._acted_on:
            return
        if estimate.out_of_range:  # its interval may not hold: as if there were no estimate
            self.loop.counts.unused += estimate.final
            return
        now = estimate.contact.sample / self._rate + estimate.available
        if estimate.final:
            # The final estimate comes with the block that made it final, not with its last sample.
            complete = estimate.complete if self._second is None else self._second
            now += (complete - estimate.complete) / self._rate + self._late - estimate.transport
        if self.loop.estimated(estimate, now):
            self._acted_on = estimate.elapsed

    def _send(self, command: Command) -> None:
        if self.requests.opening:
            return
        self.last = command
        self.hand.send(command)
        if self._done:  # the motor that obeys is as loud as a slip
            self._hold()


def grasp_lines(grasping: Grasping, *, real_time: bool = True) -> list[str]:
    """Return lines of text about the commands to the hand, for the end of a run.

    If ``real_time`` is false, the lines leave out deadlines. These have no meaning if samples come
    faster than they were taken.
    """
    counts = grasping.loop.counts
    lines = [
        f"hand {grasping.hand.name} with policy {grasping.loop.policy.name}: "
        f"{counts.commands} commands in {counts.closings} closings, "
        f"{counts.contacts} of these with a contact"
    ]
    if counts.withdrawn:
        lines.append(f"{counted(counts.withdrawn, 'contact')} withdrawn: the hand went on closing")
    if real_time:
        lines.append(
            f"{counts.estimates} estimates reached the hand within the policy's time limit and "
            f"before the second contact; {counts.overtaken} within the limit, but after the second "
            f"contact; {counts.misses} contacts had none within the limit; {counts.unused} "
            "estimates were not used: past the limit, or out of range"
        )
    if grasping.slips:
        lines.append(f"{grasping.slips} slip signals: new slips, and slips that went on")
    if isinstance(grasping.hand, SafeHand):
        c = grasping.hand.counts
        lines.append(
            f"{c.sent} commands went to the hand, and {c.repeated} repeats that kept it from "
            f"timing out; {c.superseded} were not sent, since a newer one or a release came first; "
            f"{c.clipped} asked for more than the hand can do and were reduced to that; the hand "
            f"was released {c.released} times"
        )
    return lines
