"""Live events to a grasp policy, and its commands to a hand."""

from __future__ import annotations

from firstcontact.core import Block, Command, Layout
from firstcontact.grasp.hand import Hand
from firstcontact.grasp.loop import GraspLoop
from firstcontact.grasp.policy import Policy, Stiffness
from firstcontact.grasp.safe import SafeHand
from firstcontact.grasp.taxels import Taxels
from firstcontact.live.events import Armed, Estimated, Event, PinchDone, Running, Settled, Touched


class Grasping:
    """Drives a hand through the closings of a live session; an actor of it.

    Where an any-time model answers, the policy is told the one answer that stands, and estimates
    of fixed windows are left aside; one that is out of range counts as none.

    Times are those of the samples, with the computing added where an estimate is
    told: what the deadline is held against.

    Parameters
    ----------
    policy
        What decides.
    hand
        Open. A :class:`~firstcontact.grasp.safe.SafeHand` is told with every block that
        the session lives.
    layout
        Of the samples.
    deadline
        For an estimate, s after the first contact; None takes the policy's own.
    """

    def __init__(
        self, policy: Policy, hand: Hand, layout: Layout, deadline: float | None = None
    ) -> None:
        self.hand = hand
        self.loop = GraspLoop(policy, self._send, layout.rate, deadline)
        #: What the hand was told last, None before the first.
        self.last: Command | None = None
        self._taxels = Taxels(layout)
        self._rate = layout.rate
        self._epoch = 0
        self._done = True
        self._running = self._settled = False

    def happened(self, event: Event) -> None:
        """Let the policy answer to an event."""
        match event:
            case Armed():
                self._epoch = event.epoch
                self._done = False
                self._running = self._settled = False
                self._taxels.begin()
                self.loop.begin()
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
                self.loop.done()

    def came(self, block: Block) -> None:
        """Let the policy feel the force, and see the time pass."""
        if isinstance(self.hand, SafeHand):
            self.hand.alive()
        if not self._done and block.epoch == self._epoch:
            self.loop.felt(self._taxels.update(block.data), block.end / self._rate)

    def _stands(self, event: Settled) -> None:
        """Tell what stands, once: a hand that acted on it cannot take that back."""
        answer = event.answer
        if self._settled or answer is None:
            return
        self._settled = True
        if answer.strange:  # its interval may not hold: as if there were no estimate
            self.loop.counts.unused += 1
            return
        late = (event.complete - answer.complete) / self._rate
        now = answer.contact.sample / self._rate + answer.after(self._rate) + late
        told = Stiffness(answer.value, answer.low, answer.high, answer.duration, standing=True)
        self.loop.estimated(told, now)

    def ended(self) -> None:
        """Let go, before anything slower is closed."""
        self.hand.release()

    def _send(self, command: Command) -> None:
        self.last = command
        self.hand.send(command)


def grasp_lines(grasping: Grasping) -> list[str]:
    """What the hand was told, for the end of a run."""
    counts = grasping.loop.counts
    lines = [
        f"hand {grasping.hand.name}, policy {grasping.loop.policy.name}",
        f"{counts.commands} commands in {counts.closings} closings, {counts.contacts} with contact",
        f"deadline: {counts.estimates} estimates in time, {counts.misses} missed, "
        f"{counts.unused} too late to be used",
    ]
    if isinstance(grasping.hand, SafeHand):
        c = grasping.hand.counts
        lines.append(
            f"sent {c.sent}, clipped {c.clipped}, superseded {c.superseded}, "
            f"repeated {c.repeated}, released {c.released}"
        )
    return lines
