"""Closings on request: who requested them, their end, and the release of the hand."""

import threading
from math import inf

import numpy as np
import pytest
from example_events import FIRST_EVENT, SECOND_EVENT, pinch

from firstcontact.contact import SlipDetector
from firstcontact.core import Block, Command, InputError, fingertip_layout
from firstcontact.device.clock import TransportDelay
from firstcontact.grasp import Hand, HandLimits, SafeHand
from firstcontact.grasp.hand import Begins
from firstcontact.grasp.registry import live_policy
from firstcontact.streaming import ClosingStart, Event, HandCommand
from firstcontact.streaming.events import Ask
from firstcontact.streaming.grasping import SILENCE, Grasping, HandRequests

LAYOUT = fingertip_layout()
#: Stands for a closing that the hand was requested to begin.
STARTED = Command(-1.0, -1.0)


class LoggedHand(Hand):
    """Hand that records its orders."""

    name = "told"
    limits = HandLimits(speed=0.2, force=12.0, rate=1e3, watchdog=inf)
    begins = Begins.US

    def __init__(self, begins: Begins = Begins.US) -> None:
        self.begins = begins  # type: ignore[misc]
        self.commands: list[Command | None] = []

    def send(self, command: Command) -> None:
        self.commands.append(command)

    def start(self) -> None:
        self.commands.append(STARTED)

    def release(self) -> None:
        self.commands.append(None)

    def close(self) -> None:
        self.release()


class Session:
    """Stream of consecutive blocks for a driven hand."""

    def __init__(self, grasping: Grasping) -> None:
        self.grasping = grasping
        self.sample = 0
        self.late = 0.0

    def block(self, *events: Event) -> list[HandCommand]:
        """Return the next block and its events."""
        block = Block(np.zeros((5, LAYOUT.width), np.int16), self.sample, 0)
        self.sample = block.end
        self.grasping.on_samples(block, block.end / LAYOUT.rate + self.late)
        for event in events:
            self.grasping.on_event(event)
        return [
            event for event in self.grasping.after_block(block) if isinstance(event, HandCommand)
        ]


def driven(hand: Hand, policy: str = "touch") -> Session:
    return Session(Grasping(live_policy(policy), hand, LAYOUT))


def test_a_closing_is_begun_by_who_asks_and_held_until_it_is_opened() -> None:
    hand = LoggedHand()
    session = driven(hand)
    requests, approach = session.grasping.requests, session.grasping.loop.policy.grip.approach
    assert requests.allowed == (Ask.CLOSE, Ask.OPEN)
    session.block()
    assert hand.commands == []
    requests.ask(Ask.CLOSE, "keyboard")
    assert [(e.ask, e.by) for e in session.block()] == [(Ask.CLOSE, "keyboard")]
    assert hand.commands == [approach]
    session.block(ClosingStart(15, 0))  # its own motor
    assert hand.commands == [approach]
    session.block(FIRST_EVENT)
    assert isinstance(hand.commands[-1], Command)
    assert hand.commands[-1] != approach
    predictions = list(hand.commands)
    finished_pinch = pinch(start=15, end=600)
    session.block(finished_pinch)
    session.block(ClosingStart(700, 0), FIRST_EVENT)
    assert hand.commands == predictions, "it holds what it has"
    with pytest.raises(InputError, match="closed already"):
        requests.ask(Ask.CLOSE, "somebody else")
    requests.ask(Ask.OPEN, "somebody else")
    assert hand.commands[-1] is None, "at once"
    assert [(e.ask, e.by) for e in session.block()] == [(Ask.OPEN, "somebody else")]
    assert session.grasping.loop.counts.closings == 1
    requests.ask(Ask.CLOSE, "keyboard")
    session.block()
    assert hand.commands[-1] == approach


def test_a_hand_that_closes_by_itself_may_begin_its_next_closing_on_request() -> None:
    hand = LoggedHand(Begins.OTHERS | Begins.HURRY)
    session = driven(hand)
    requests, approach = session.grasping.requests, session.grasping.loop.policy.grip.approach
    assert requests.allowed == (Ask.CLOSE, Ask.OPEN)
    for _ in range(2):  # it opens by itself, so that no request to open comes between
        requests.ask(Ask.CLOSE, "viewer 1")
        assert [(e.ask, e.by) for e in session.block()] == [(Ask.CLOSE, "viewer 1")]
        assert hand.commands == [STARTED]
        session.block(ClosingStart(session.sample, 0))
        assert hand.commands == [STARTED, approach]
        session.block(pinch(start=15, end=600))
        hand.commands.clear()
    requests.gone("viewer 1")
    assert session.block() == []
    assert hand.commands == [], "the hand is not theirs to open"


def test_nothing_is_sent_between_the_request_to_open_and_the_opening() -> None:
    hand = LoggedHand()
    session = driven(hand)
    session.grasping.requests.ask(Ask.CLOSE, "keyboard")
    session.block()
    session.block(ClosingStart(15, 0))
    session.grasping.requests.ask(Ask.OPEN, "keyboard")
    session.grasping.on_event(FIRST_EVENT)
    assert hand.commands[-1] is None
    session.block()
    session.block(SECOND_EVENT)
    assert hand.commands[-1] is None


def test_who_is_gone_leaves_an_open_hand() -> None:
    hand = LoggedHand()
    session = driven(hand)
    requests = session.grasping.requests
    requests.ask(Ask.CLOSE, "viewer 1")
    session.block()
    requests.gone("viewer 2")
    assert session.block() == []
    assert hand.commands[-1] is not None
    requests.gone("viewer 1")
    assert hand.commands[-1] is None
    assert [(e.ask, e.by) for e in session.block()] == [(Ask.OPEN, "viewer 1")]
    requests.ask(Ask.CLOSE, "viewer 1")  # on its way when it went
    assert session.block() == []
    requests.gone("viewer 3")  # before its wish was obeyed
    requests.ask(Ask.CLOSE, "viewer 3")
    assert session.block() == []
    assert requests.by is None


def test_a_hand_that_was_released_by_a_silence_stays_open() -> None:
    """Later contacts of the same closing do not close the hand again."""
    now = [0.0]
    hand = LoggedHand()
    with SafeHand(hand, silence=1.0, clock=lambda: now[0]) as safe:
        session = driven(safe)
        session.grasping.requests.ask(Ask.CLOSE, "keyboard")
        session.block()
        session.block(ClosingStart(15, 0))
        now[0] += 5.0
        assert [(e.ask, e.by) for e in session.block()] == [(Ask.OPEN, SILENCE)]
        session.block(FIRST_EVENT)
        assert hand.commands[-1] is None


def test_what_is_older_than_a_silence_does_not_close_a_hand(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    hand = LoggedHand(Begins.US | Begins.OTHERS)
    transport = TransportDelay(LAYOUT.rate)
    session = Session(Grasping(live_policy("touch"), hand, LAYOUT, transport=transport))
    session.block()
    session.late = 1.5  # samples
    session.block(ClosingStart(5, 0), FIRST_EVENT)
    assert hand.commands == []
    session.late = 0.0
    monkeypatch.setattr("firstcontact.streaming.grasping.STALE", 0.0)  # requests
    session.grasping.requests.ask(Ask.CLOSE, "keyboard")
    assert session.block() == []
    assert hand.commands == []


def test_samples_that_stay_late_release_the_hand_and_count_no_command() -> None:
    driver, now = LoggedHand(), [0.0]
    with SafeHand(driver, silence=1.0, clock=lambda: now[0]) as hand:
        transport = TransportDelay(LAYOUT.rate)
        grasping = Grasping(live_policy("touch"), hand, LAYOUT, transport=transport)
        session = Session(grasping)
        session.block()
        grasping.requests.ask(Ask.CLOSE, "keyboard")
        session.block()
        sent = grasping.loop.counts.commands
        session.late = 1.5
        session.block(FIRST_EVENT)
        assert grasping.loop.counts.commands == sent == 1
        released: list[HandCommand] = []
        for _ in range(4):
            now[0] += 0.3
            released += session.block()
        assert [(event.ask, event.by) for event in released] == [(Ask.OPEN, SILENCE)]
        grasping.requests.ask(Ask.CLOSE, "keyboard")
        assert session.block() == []
    assert driver.commands[-1] is None


def test_a_hand_that_begins_by_itself_can_only_be_opened() -> None:
    hand = LoggedHand(Begins.OTHERS)
    session = driven(hand)
    assert session.grasping.requests.allowed == (Ask.OPEN,)
    with pytest.raises(InputError, match=f"{LoggedHand.name}.* only to open"):
        session.grasping.requests.ask(Ask.CLOSE, "keyboard")
    session.block(ClosingStart(15, 0))
    session.grasping.requests.ask(Ask.OPEN, "keyboard")
    session.block(FIRST_EVENT)
    session.block(SECOND_EVENT)
    assert hand.commands[-1] is None, "until it closes again"
    session.block(ClosingStart(900, 0))
    assert hand.commands[-1] is not None


def test_requests_of_many_threads_end_with_an_open_hand() -> None:
    hand = LoggedHand()
    session = driven(hand)
    requests: HandRequests = session.grasping.requests

    def ask(number: int) -> None:
        for _ in range(50):
            try:
                requests.ask(Ask.CLOSE, f"viewer {number}")
            except InputError:
                requests.ask(Ask.OPEN, f"viewer {number}")
        requests.gone(f"viewer {number}")

    threads = [threading.Thread(target=ask, args=(n,)) for n in range(4)]
    for thread in threads:
        thread.start()
    while any(thread.is_alive() for thread in threads):
        session.block()
    for thread in threads:
        thread.join()
    session.block()
    assert requests.by is None
    assert hand.commands[-1] is None
    assert not requests.opening


class Alarms(SlipDetector):
    """Slip detector that reports a slip in every block while an object is held."""

    name = "alarms"
    is_holding = False

    def start(self, layout: object) -> None:
        self.is_holding = False

    def hold(self) -> None:
        self.is_holding = True

    def release(self) -> None:
        self.is_holding = False

    def update(self, block: Block) -> list[int]:
        return [block.first_sample] if self.is_holding else []


def test_a_slip_of_what_is_held_is_told_until_the_hand_opens() -> None:
    for begins, predictions in ((Begins.US, True), (Begins.OTHERS, False)):
        hand = LoggedHand(begins)
        session = Session(Grasping(live_policy("slip_reflex"), hand, LAYOUT, slip=Alarms()))
        if predictions:
            session.grasping.requests.ask(Ask.CLOSE, "keyboard")
        session.block()
        session.block(ClosingStart(5, 0), FIRST_EVENT, SECOND_EVENT)
        assert session.grasping.slips == 0, "a closing is loud"
        original = hand.commands[-1]
        session.block(pinch(start=5, end=600))
        session.block()
        current = hand.commands[-1]
        assert (current.force > original.force) is predictions
        # When somebody else opens the hand is not known: that motor must not be held on to.
        assert bool(session.grasping.slips) is predictions
        session.grasping.requests.ask(Ask.OPEN, "keyboard")
        session.block()
        session.block()
        assert hand.commands[-1] is None
