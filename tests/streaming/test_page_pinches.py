"""The table of pinches on the page, and where an estimate's time went."""

from __future__ import annotations

from msgspec.structs import replace
from page_feed import RATE, Feed

from firstcontact.core import Label
from firstcontact.device._twin_words import lost_text
from firstcontact.recording import Marker, PinchMark
from firstcontact.streaming import PinchDone
from firstcontact.streaming.page._rows import PinchRows


def pinch(feed: Feed) -> PinchDone:
    while True:
        for event in feed.update().events:
            if isinstance(event, PinchDone):
                return event


def test_a_pinch_has_the_word_that_was_said_for_it() -> None:
    feed = Feed()
    pinches = PinchRows()
    pinch(feed)
    done = [pinch(feed) for _ in range(4)]
    pinches.add_marker(Marker(done[0].start - 100, "before"))
    pinches.done(done[0])
    pinches.done(done[1])
    pinches.add_marker(Marker(done[1].start + 10, "late"))
    pinches.add_marker(Marker(done[2].start + 1, "other epoch", epoch=3))
    pinches.done(done[2])
    pinches.done(done[3])
    label = Label("apple", 68.0)
    pinches.add_label(PinchMark(0, done[3].start - 5, done[3].end, 0, label))
    assert [row.name for row in pinches.rows] == ["before", "late", "", "apple"]


def test_a_pinch_has_what_the_twin_says_became_of_it_whenever_that_comes() -> None:
    feed = Feed()
    pinch(feed)
    first, second, third = (pinch(feed) for _ in range(3))
    pinches = PinchRows()
    pinches.done(first)
    pinches.add_marker(Marker(first.end + 5, lost_text("broken")))
    assert [row.lost for row in pinches.rows] == ["broken"]
    pinches.add_marker(Marker(second.end - 1, lost_text("dropped")))
    pinches.done(second)
    pinches.add_marker(Marker(second.end, lost_text("dropped"), epoch=3))
    pinches.done(third)
    assert [row.lost for row in pinches.rows] == ["broken", "dropped", None]
    assert [row.name for row in pinches.rows] == ["", "", ""]


def test_a_row_holds_the_estimate_in_force_and_the_final_one() -> None:
    done = pinch(Feed())
    first = replace(done.estimates[0], available=15 / RATE)
    between = replace(first, value=55.0)
    assert done.offset is not None
    later = replace(first, value=99.0, available=done.offset + 0.001)
    pinches = PinchRows()
    pinches.done(replace(done, estimates=(first, between, later)))
    pinches.done(replace(done, estimates=(later,)))
    pinches.done(replace(done, estimates=(), contacts=(), reason="a gap"))
    values = [[e.value for e in row.pinch.estimates] for row in pinches.rows]
    assert values == [[55.0, 99.0], [99.0], []]
    assert pinches.rows[1].pinch.in_force is None
    assert pinches.rows[2].pinch.reason == "a gap"
