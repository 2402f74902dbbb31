"""Link between a live session and a hand: the policy gets events, and the hand its commands."""

from __future__ import annotations

import logging
import math
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from threading import Lock

import numpy as np

from firstcontact.contact import SlipDetector
from firstcontact.core import Block, Command, DeviceError, Estimate, Layout
from firstcontact.core.text import counted
from firstcontact.device.clock import TransportDelay
from firstcontact.grasp import Hand, Policy, SafeHand
from firstcontact.grasp.hand import Begins, steady_clock
from firstcontact.grasp.loop import GraspLoop, Taxels
from firstcontact.streaming.events import (
    Ask,
    ClosingStart,
    ContactEvent,
    ContactWithdrawn,
    Event,
    HandCommand,
    NoEstimate,
    PinchDone,
    PolicyCommand,
)

#: Name of the origin of a release that follows a silence of the samples or of this program.
SILENCE = "silence"
#: Longest time between two reports of a position over which it is interpolated, in periods of the
#: hand's rate.
PAUSE = 2.5
#: Age from which a request to close, and samples, are too old to move a hand, s.
STALE = 1.0

_log = logging.getLogger("firstcontact.streaming")


@dataclass(frozen=True, slots=True)
class HandRequest:
    """Request of ``by``, such as a viewer of the page, to close or open the hand.

    ``ask`` is None if ``by`` has disconnected. ``time`` is that of the request by
    ``time.monotonic()``, s.
    """

    ask: Ask | None
    by: str
    time: float = field(default_factory=steady_clock)


class HandRequests:
    """Queue of requests to the hand from any thread, which the session's thread carries out."""

    def __init__(self, name: str, begins: Begins, release: Callable[[], None]) -> None:
        #: Origin of the request that closed the hand; None while no request holds it closed.
        self.by: str | None = None
        #: True if a request to open waits.
        self.opening = False
        self._name, self._begins, self._release = name, begins, release
        self._waiting: deque[HandRequest] = deque()
        self._gone: set[str] = set()
        self._lock = Lock()  # of opening, _waiting and _gone
        self._over = False

    @property
    def allowed(self) -> tuple[Ask, ...]:
        return tuple(Ask) if self._begins & (Begins.US | Begins.HURRY) else (Ask.OPEN,)

    def ask(self, ask: Ask, by: str) -> None:
        if self._over:
            raise DeviceError("The session has ended: run the command again")
        if ask is Ask.OPEN:
            self._open(HandRequest(ask, by))
            return
        if ask not in self.allowed:
            raise DeviceError(
                f"The hand {self._name!r} closes by itself, so it cannot be closed "
                "on request: request only to open it"
            )
        if self.by is not None and not self.opening:
            raise DeviceError("The hand is closed already: open it first")
        with self._lock:
            if by not in self._gone:
                self._waiting.append(HandRequest(ask, by))

    def gone(self, by: str) -> None:
        """Open the hand if the viewer ``by``, who has disconnected, had closed it."""
        with self._lock:
            self._gone.add(by)
            if self.by != by:
                self._waiting.append(HandRequest(None, by))
                return
        self._open(HandRequest(None, by))

    def end(self) -> None:
        self._over = True

    def take(self) -> HandRequest | None:
        """Remove and return the next request, or None. Only the session's thread may call this."""
        with self._lock:
            self.opening = any(self.opens(request) for request in self._waiting)
            while self._waiting:
                request = self._waiting.popleft()
                if request.ask is not Ask.CLOSE or steady_clock() - request.time < STALE:
                    return request
            return None

    def opens(self, request: HandRequest) -> bool:
        return request.ask is Ask.OPEN or (request.ask is None and request.by == self.by)

    def _open(self, request: HandRequest) -> None:
        with self._lock:
            self.opening = True
            self._waiting.append(request)
        self._release()


class PositionTrack:
    """Positions of a hand's fingers, interpolated to the constant rate of a recording's columns."""

    def __init__(self, hand: Hand, dtype: str, epoch: int, start: float) -> None:
        self.epoch = epoch
        self._hand, self._rate, self._dtype = hand, hand.position_rate, np.dtype(dtype)
        self._next = math.ceil(start * self._rate)
        self._reports: list[tuple[float, ...]] = []  # the newest report

    def read(self, host_zero: float) -> list[Block]:
        """Return new positions up to the hand's newest report, interpolated between its reports.

        ``host_zero`` is the time of sample 0 by ``time.monotonic()``, s.
        """
        since = self._reports[0][0] if self._reports else (self._next - PAUSE) / self._rate
        self._reports += self._hand.positions_since(since, host_zero)
        if len(self._reports) < 2:
            return []
        times, travel = np.array(self._reports)[:, :2].T
        self._reports = self._reports[-1:]
        first = max(self._next, math.ceil(times[0] * self._rate))
        numbers = np.arange(first, math.floor(times[-1] * self._rate) + 1)
        if not len(numbers):
            return []
        self._next = int(numbers[-1]) + 1
        at = numbers / self._rate
        after = np.searchsorted(times, at).clip(max=len(times) - 1)
        known = times[after] - times[np.maximum(after - 1, 0)] <= PAUSE / self._rate
        steps = np.interp(at, times, travel) / self._hand.position_resolution
        if self._dtype.kind == "i":
            limits = np.iinfo(self._dtype)
            steps = np.clip(np.rint(steps), limits.min, limits.max)
        data, numbers = steps.astype(self._dtype)[known, np.newaxis], numbers[known]
        cuts = np.flatnonzero(np.diff(numbers) > 1) + 1
        runs = zip(np.split(numbers, cuts), np.split(data, cuts), strict=True)
        return [Block(run, int(n[0]), self.epoch) for n, run in runs if len(n)]


class Grasping:
    """Event handler that drives a hand through the closings of a live session.

    The motor's start begins a closing only for hands that close by themselves: the motor of another
    hand may also open it. The policy gets each estimate as soon as it is there. If the newest one
    is out of range, the policy acts as without an estimate. The slip detector works in requested
    closings, from their end until the hand opens.
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
        self._safe = hand if isinstance(hand, SafeHand) else None
        wait = (lambda: hand.wait) if isinstance(hand, SafeHand) else (lambda: 0.0)
        self.loop = GraspLoop(policy, self._send, layout.rate, deadline, wait)
        #: Requests of viewers and the keyboard.
        self.requests = HandRequests(hand.name, hand.begins, hand.release)
        #: Last command, None before the first.
        self.last: Command | None = None
        #: Number of slips so far.
        self.slips = 0
        #: True if the hand used an estimate of the last pinch before its second contact. None for
        #: a policy that uses no estimates.
        self.is_used: bool | None = None
        self._taxels = Taxels(layout)
        self._rate = layout.rate
        self._transport = transport
        self._slip = slip
        if slip is not None:
            slip.start(layout)
        self._commands: list[Command] = []  # sent, but not yet taken as events
        self._newest = 0, 0  # number and epoch of the newest sample
        self._late = 0.0  # delay of the newest samples beyond the least delayed ones, s
        self._epoch = 0
        self._done = True
        self._acted_on = -1.0  # elapsed time of the estimate that the policy acted on, s

    def on_samples(self, block: Block, host: float) -> None:
        self._newest = block.end - 1, block.epoch
        before = self._late
        if self._transport is not None:
            self._transport.add(block, host)
            self._late = self._transport.delay(block.end - 1, host)
        if self._late > STALE >= before:
            _log.warning(
                "samples are %.1f s late: the hand %s gets no commands, and is released if they "
                "stay late",
                self._late,
                self.hand.name,
            )
        if self._safe is not None and self._late <= STALE:
            self._safe.alive()

    def on_event(self, event: Event) -> None:
        match event:
            case ClosingStart():
                self._closing_starts(event)
            case ContactEvent():
                self.loop.touched(event.contact, event.first, event.contact.decided / self._rate)
            case ContactWithdrawn():
                self._forget_contact()
                self.loop.withdrawn()
            case Estimate():
                self._process_estimate(event)
            case NoEstimate():
                self.loop.retract()
            case PinchDone():
                self._done = True
                self._hold()
                is_used = self.loop.finish(event.second)
                self.is_used = None if self.loop.policy.deadline is None else is_used

    def after_block(self, block: Block) -> Sequence[Event]:
        """Carry out the requests and commands that are due after a block. Return their events."""
        events: list[Event] = [*self._obey(block)]
        now = block.end / self._rate + self._late
        if not self._done and block.epoch == self._epoch:
            self.loop.felt(self._taxels.update(block.data), now)
        if self._slip is not None and self._slip.update(block):
            self.slips += 1
            self.loop.slipped(now)
        return [*events, *self.take_commands()]

    def take_commands(self) -> list[PolicyCommand]:
        """Return one event for each command that was sent to the hand since the last call."""
        commands, self._commands = self._commands, []
        return [PolicyCommand(c.speed, c.force, *self._newest) for c in commands]

    def ended(self) -> None:
        """Open the hand at the end of a session, before outputs are closed, which may be slow."""
        self.requests.end()
        self.hand.release()

    def _closing_starts(self, event: ClosingStart) -> None:
        """Process the start of the motor. If the hand closes by itself, a closing begins."""
        is_requested = self.requests.by is not None
        if is_requested or Begins.OTHERS in self.hand.begins:
            self._epoch = event.epoch
            self._taxels.begin()
            if not is_requested:
                self._begin()

    def _begin(self) -> None:
        self._done = False
        self._forget_contact()
        if self._slip is not None:
            self._slip.release()
        self.loop.begin()

    def _forget_contact(self) -> None:
        self._acted_on = -1.0

    def _hold(self) -> None:
        # A hand that opens by itself does not say so: its motor would pass for a slip.
        if self._slip is not None and self.requests.by is not None:
            self._slip.hold()

    def _obey(self, block: Block) -> list[Event]:
        obeyed: list[tuple[Ask, str]] = []
        if self._is_silenced:  # before requests, which may be new
            self._open()
            obeyed.append((Ask.OPEN, SILENCE))
        while request := self.requests.take():
            if request.ask is Ask.CLOSE:
                if Begins.HURRY in self.hand.begins:
                    self.hand.start()  # the start of its motor then begins the closing
                elif self.requests.by is None and self._late <= STALE:
                    self.requests.by = request.by
                    self._epoch = block.epoch
                    self._taxels.begin()
                    self._begin()
                else:
                    continue
                obeyed.append((Ask.CLOSE, request.by))
            elif self.requests.opens(request):
                self._open()
                obeyed.append((Ask.OPEN, request.by))
        for ask, origin in obeyed:
            _log.info("hand %s: %s, requested by %s", self.hand.name, ask, origin)
        return [HandCommand(ask, origin, block.end - 1, block.epoch) for ask, origin in obeyed]

    def _open(self) -> None:
        self.requests.by = None
        self._done = True
        self.loop.finish()
        self.loop.released()
        if self._slip is not None:
            self._slip.release()
        self.hand.release()

    @property
    def host_zero(self) -> float:
        """Time of sample 0 by ``time.monotonic()``, s; NaN if unknown."""
        return math.nan if self._transport is None else self._transport.least

    @property
    def _is_silenced(self) -> bool:
        return self._safe is not None and self._safe.silenced

    def _process_estimate(self, estimate: Estimate) -> None:
        """Pass an estimate to the policy, unless the policy has used an estimate of equal length.

        An estimate that is out of range counts as missing.
        """
        if estimate.out_of_range:  # its interval may not hold: as if there were no estimate
            self.loop.counts.unused += estimate.final
            self._acted_on = -1.0  # so that a final estimate from fewer samples counts again
            self.loop.retract()
            return
        if estimate.final and estimate.elapsed == self._acted_on:
            return
        now = estimate.contact.sample / self._rate + estimate.available
        if estimate.final:  # it comes with the samples that made it final, not with its own
            now = max(now, (self._newest[0] + 1) / self._rate + self._late)
        if self.loop.estimated(estimate, now):
            self._acted_on = estimate.elapsed

    def _send(self, command: Command) -> bool:
        """Send a command to the hand, and return True.

        Return False without sending if the hand must stay open, or if the samples are too old.
        """
        if self.requests.opening or self._is_silenced or self._late > STALE:
            return False
        self.last = command
        self.hand.send(command)
        self._commands.append(command)
        if self._done:  # the motor that obeys is as loud as a slip
            self._hold()
        return True

    def lines(self, *, real_time: bool = True) -> list[str]:
        """Return sentences for the end of a session, on commands, contacts and used estimates.

        ``real_time`` is True if estimates could be rated as in time or too late.
        """
        counts = self.loop.counts
        lines = [
            f"hand {self.hand.name} with policy {self.loop.policy.name}: {counts.commands} "
            f"commands in {counts.closings} closings, {counts.contacts} of these with a contact"
        ]
        if counts.withdrawn:
            withdrawn = counted(counts.withdrawn, "contact")
            lines.append(f"{withdrawn} withdrawn: the hand went on closing")
        if real_time:
            lines.append(
                f"the hand used an estimate after {counted(counts.estimates, 'contact')}, within "
                "the policy's time limit and before the second contact; after "
                f"{counts.overtaken} within the limit, but after the second contact; "
                f"{counts.misses} had no usable estimate within the limit"
            )
        if counts.unused:
            unused = counted(counts.unused, "estimate")
            lines.append(f"{unused} had no effect: past the policy's time limit, or out of range")
        if self.slips:
            lines.append(f"{self.slips} slip signals: new slips, and slips that went on")
        if self._safe is not None:
            c = self._safe.counts
            lines.append(
                f"{c.sent} commands went to the hand, and {c.repeated} repeats that kept it from "
                f"timing out; {c.superseded} were not sent, since a newer one or a release came "
                f"first; {c.clipped} asked for more than the hand can do and were reduced to that; "
                f"the hand was released {c.released} times"
            )
        return lines
