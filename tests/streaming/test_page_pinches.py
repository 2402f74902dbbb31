"""The table of pinches on the page, and where an estimate's time went."""

from page_feed import Feed

from firstcontact.core import Label
from firstcontact.device.twin_words import lost_text
from firstcontact.recording import Marker, PinchMark
from firstcontact.streaming import PinchDone
from firstcontact.streaming.page.state import PinchRows


def pinch(feed: Feed) -> PinchDone:
    while True:
        for event in feed.update().events:
            if isinstance(event, PinchDone):
                return event


def test_a_pinch_has_the_word_that_was_said_for_it() -> None:
    feed = Feed()
    pinches = PinchRows()
    pinch(feed)
    finished_pinch = [pinch(feed) for _ in range(4)]
    pinches.add_marker(Marker(finished_pinch[0].start - 100, "before"))
    pinches.add_pinch(finished_pinch[0])
    pinches.add_pinch(finished_pinch[1])
    pinches.add_marker(Marker(finished_pinch[1].start + 10, "late"))
    pinches.add_marker(Marker(finished_pinch[2].start + 1, "other epoch", epoch=3))
    pinches.add_pinch(finished_pinch[2])
    pinches.add_pinch(finished_pinch[3])
    label = Label("apple", 68.0)
    pinches.add_label(PinchMark(0, finished_pinch[3].start - 5, finished_pinch[3].end, 0, label))
    assert [row.name for row in pinches.rows] == ["before", "late", "", "apple"]


def test_a_pinch_has_what_the_twin_says_became_of_it_whenever_that_comes() -> None:
    feed = Feed()
    pinch(feed)
    first, second, third = (pinch(feed) for _ in range(3))
    pinches = PinchRows()
    pinches.add_pinch(first)
    pinches.add_marker(Marker(first.end + 5, lost_text("broken")))
    assert [row.lost for row in pinches.rows] == ["broken"]
    pinches.add_marker(Marker(second.end - 1, lost_text("dropped")))
    pinches.add_pinch(second)
    pinches.add_marker(Marker(second.end, lost_text("dropped"), epoch=3))
    pinches.add_pinch(third)
    assert [row.lost for row in pinches.rows] == ["broken", "dropped", None]
    assert [row.name for row in pinches.rows] == ["", "", ""]
