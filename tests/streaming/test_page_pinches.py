"""The table of pinches on the page, and where an estimate's time went."""

from __future__ import annotations

from dataclasses import replace

import pytest
from page_feed import Feed

from firstcontact.core import Label
from firstcontact.device._twin_words import lost_text
from firstcontact.recording import Marker, PinchMark
from firstcontact.streaming import PinchDone
from firstcontact.streaming.page._pinches import Pinches, timing


def test_time_is_taken_apart_without_rest() -> None:
    estimate = replace(Feed().estimate, transport=0.004)
    parts = timing(estimate, 4936.0)
    assert parts["window"] == 15.0
    total = parts["window"] + parts["wait"] + parts["transport"] + parts["compute"]
    assert parts["total"] == pytest.approx(total, abs=0.002)
    early = replace(estimate, complete=estimate.contact.sample + 40)
    assert timing(early, 4936.0)["wait"] == 0.0


def pinch(feed: Feed) -> PinchDone:
    while True:
        for event in feed.update().events:
            if isinstance(event, PinchDone):
                return event


def test_a_pinch_has_the_word_that_was_said_for_it() -> None:
    feed = Feed()
    pinches = Pinches(4936.0)
    pinch(feed)
    done = [pinch(feed) for _ in range(4)]
    pinches.word(Marker(done[0].armed - 100, "before"))
    pinches.done(done[0])
    pinches.done(done[1])
    pinches.word(Marker(done[1].armed + 10, "late"))
    pinches.word(Marker(done[2].armed + 1, "other epoch", epoch=3))
    pinches.done(done[2])
    pinches.done(done[3])
    label = Label("apple", 68.0)
    pinches.label(PinchMark(0, done[3].armed - 5, done[3].end, 0, label))
    assert [row["object"] for row in pinches.tree()] == ["before", "late", "", "apple"]


def test_a_pinch_has_what_the_twin_says_became_of_it_whenever_that_comes() -> None:
    feed = Feed()
    pinch(feed)
    first, second, third = (pinch(feed) for _ in range(3))
    pinches = Pinches(4936.0)
    pinches.done(first)
    pinches.word(Marker(first.end + 5, lost_text("broken")))
    assert [row["lost"] for row in pinches.tree()] == ["broken"]
    pinches.word(Marker(second.end - 1, lost_text("dropped")))
    pinches.done(second)
    pinches.word(Marker(second.end, lost_text("dropped"), epoch=3))
    pinches.done(third)
    assert [row["lost"] for row in pinches.tree()] == ["broken", "dropped", None]
    assert [row["object"] for row in pinches.tree()] == ["", "", ""]


def test_the_last_estimate_in_time_is_the_one_in_the_table() -> None:
    done = pinch(Feed())
    first = replace(done.estimates[0], complete=done.contacts[0].sample + 15)
    later = replace(first, value=99.0, complete=done.contacts[1].sample)
    pinches = Pinches(4936.0)
    pinches.done(replace(done, estimates=(first, later)))
    pinches.done(replace(done, estimates=(later,)))
    pinches.done(replace(done, estimates=(), contacts=(), refused="a gap"))
    rows = pinches.tree()
    assert rows[0]["estimate"]["value"] == round(first.value, 2)
    assert rows[0]["later"]["value"] == 99.0
    assert (rows[1]["estimate"], rows[1]["later"]["value"]) == (None, 99.0)
    assert (rows[2]["estimate"], rows[2]["finger"], rows[2]["refused"]) == (None, None, "a gap")
