"""What the page shows: present values, columns of traces, and the table of pinches."""

from typing import Any

import numpy as np
from example_events import (
    ANSWER,
    EVENTS,
    FIRST,
    FIRST_EVENT,
    OF_HAND,
    RATE,
    SECOND_EVENT,
    numbered,
    page_state,
    pinch,
    timed,
)
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace
from page_feed import LAYOUT, Feed, Requests

from firstcontact.core import Block, Contact, Finger, Label
from firstcontact.device import Health
from firstcontact.device.twin_words import lost_text
from firstcontact.recording import Marker, PinchMark
from firstcontact.streaming import HandPinch, ObjectEstimate, PinchDone, Update
from firstcontact.streaming.page.sink import PageSink
from firstcontact.streaming.page.state import PinchRows
from firstcontact.streaming.page.traces import AFTER, BEFORE, Closeup, Columns
from page_browser import needs_browser, text, until

#: An estimate each millisecond from 2 to 15, narrower each time; the last but one is final.
ESTIMATES = tuple(
    timed(
        ANSWER,
        low=30.5 - 30 / ms,
        high=30.5 + 30 / ms,
        elapsed=round(4.936 * ms) / RATE,
        complete=FIRST.sample + round(4.936 * ms) - 1,
    )
    for ms in range(2, 16)
)
FINAL = replace(ESTIMATES[-2], final=True)
DONE = pinch(*ESTIMATES[:-1])
(HAND,) = (event for event in EVENTS if isinstance(event, HandPinch))
COMBINED = ObjectEstimate(
    number=1, value=30.5, low=22.0, high=39.0, level=0.9, pinches=3, end=1600, epoch=0
)


def milliseconds(now: dict[str, Any]) -> list[int]:
    return [round(1e3 * e["elapsed"]) for e in now["estimates"]]


def test_estimates_come_one_by_one_and_end_with_the_final_one() -> None:
    going = page_state(FIRST_EVENT, *ESTIMATES[:5])["now"]
    assert milliseconds(going) == [2, 3, 4, 5, 6]
    assert going["pinch"] is None
    now = page_state(FIRST_EVENT, *ESTIMATES, SECOND_EVENT, FINAL, DONE, COMBINED)["now"]
    assert milliseconds(now) == list(range(2, 15))
    assert [e["final"] for e in now["estimates"]] == [False] * 12 + [True]
    (in_force,) = now["pinch"]["estimates"]
    assert in_force["low"] == ESTIMATES[-2].low  # of 14 ms, available after 14.1
    assert (now["pinch"]["verdict"], round(1e3 * now["second"], 3)) == ("in_time", 14.182)
    assert (now["object"]["value"], now["object"]["pinches"]) == (30.5, 3)


@needs_browser
def test_it_is_drawn_and_a_new_object_is_requested(
    page: PageSink, requests: Requests, chromium: Any
) -> None:
    chromium.get(page.url)
    odd = tuple(replace(e, out_of_range=True) for e in ESTIMATES)
    events = (FIRST_EVENT, *odd, SECOND_EVENT, replace(odd[-2], final=True), COMBINED)
    page.take(Update((numbered(0, 1600),), events, Health(connected=True)))
    until(chromium, lambda d: text(d, "value") == "31")
    # It is drawn slower than it came: in the end each answer and the last are circles.
    circles = "return document.querySelectorAll('#scale circle').length"
    until(chromium, lambda d: d.execute_script(circles) == len(ESTIMATES))
    until(chromium, lambda d: "2nd: 14.2 ms" in text(d, "scale"))
    assert chromium.find_element("id", "strange").is_displayed()
    assert text(chromium, "same-word") == "Same object, 3 pinches"
    alone = replace(COMBINED, pinches=1, is_named=False)
    page.take(Update((), (alone,), Health(connected=True)))
    until(chromium, lambda d: text(d, "same-word").startswith("Press New object"))
    chromium.find_element("id", "new-object").click()
    until(chromium, lambda d: requests.calls == ["new"])
    # Nothing of the previous object stays beside the new one.
    until(chromium, lambda d: text(d, "same-value") == "")
    chromium.find_element("tag name", "body").send_keys("n")
    until(chromium, lambda d: requests.calls == ["new", "new"])
    chromium.find_element("id", "shape").send_keys("Flat")
    chromium.find_element("id", "tell-shape").click()
    until(chromium, lambda d: requests.calls[2:] == ["shape Flat"])
    until(chromium, lambda d: "flat" in text(d, "recording"))


@needs_browser
def test_card_and_row_show_the_estimate_in_force_and_a_later_one_as_a_detail(
    page: PageSink, chromium: Any
) -> None:
    early = timed(ESTIMATES[3], value=20.0, low=15.0, high=25.0)
    late = timed(ESTIMATES[-2], value=44.0, waited=0.02)
    chromium.get(page.url)
    events = (FIRST_EVENT, early, late, replace(late, final=True), pinch(early, late))
    page.take(Update((numbered(0, 1600),), events, Health(connected=True)))
    until(chromium, lambda d: text(d, "value") == "20")
    assert "in time: estimate after 5.2 ms" in text(chromium, "verdict")
    assert "44" in text(chromium, "later")
    (row,) = chromium.find_elements("css selector", "#rows tr")
    cells = [cell.text for cell in row.find_elements("tag name", "td")]
    assert cells[3].startswith("20")
    assert cells[4] == "5.2"
    assert "later 44 after 34.1 ms" in cells[6]


@needs_browser
def test_a_stiffness_is_shown_in_its_unit_on_a_scale_of_decades(
    page: PageSink, chromium: Any
) -> None:
    springs = [
        replace(e, quantity="stiffness_n_per_mm", value=14.7, low=8.0, high=27.0, modulus_mpa=None)
        for e in ESTIMATES
    ]
    chromium.get(page.url)
    events = (FIRST_EVENT, *springs, pinch(*springs[:-1]))
    page.take(Update((numbered(0, 1600),), events, Health(connected=True)))
    until(chromium, lambda d: text(d, "unit") == "N/mm")
    assert text(chromium, "value") == "14.7"
    assert text(chromium, "interval").startswith("between 8.00 and 27.0")
    ticks = chromium.execute_script(
        "return [...document.querySelectorAll('#scale text')].map((t) => t.textContent)"
    )
    assert {"1", "10", "100"} <= set(ticks)
    (row,) = chromium.find_elements("css selector", "#rows tr")
    assert "14.7" in row.text


def test_the_page_gets_the_devices_own_estimate_until_the_next_contact() -> None:
    own = page_state(FIRST_EVENT, pinch(ANSWER), HAND)["on_hand"]
    assert (own["final"]["available"], own["final"]["compute"]) == (OF_HAND.available, 441e-6)
    without = replace(HAND, final=None)
    assert page_state(FIRST_EVENT, pinch(ANSWER), without)["on_hand"]["final"] is None
    assert page_state(FIRST_EVENT, pinch(ANSWER), HAND, FIRST_EVENT)["on_hand"] is None
    assert "on_hand" not in page_state(FIRST_EVENT, pinch(ANSWER))


VOLT = LAYOUT.channels[0].scale
ZERO = LAYOUT.channels[0].offset


def block(first: int, n: int, epoch: int = 0, thumb: int = 7) -> Block:
    """Return samples whose index channel counts them, within the range of int16."""
    raw = np.full((n, len(LAYOUT.channels)), thumb, np.int16)
    raw[:, 0] = (first + np.arange(n)) % 30_000
    return Block(raw, first, epoch)


def volts(raw: float) -> float:
    return (raw - ZERO) * VOLT


@settings(max_examples=20)  # each compares thousands of columns
@given(st.lists(st.integers(1, 300), min_size=1, max_size=30), st.integers(0, 2**40))
def test_every_sample_is_in_its_column(sizes: list[int], start: int) -> None:
    columns = Columns(LAYOUT)
    at = start
    for n in sizes:
        columns.add(block(at, n))
        at += n
    first, got = columns.since(0)
    for k in range(len(got)):
        positions = start + (first + k) * columns.samples + np.arange(columns.samples)
        raw = positions % 30_000
        np.testing.assert_allclose(got[k, 0], [volts(raw.min()), volts(raw.max())], rtol=1e-5)
        np.testing.assert_allclose(got[k, 1], volts(7), rtol=1e-5)
    assert first + len(got) == (sum(sizes) - 1) // columns.samples


@given(st.integers(0, 200), st.integers(1, 40_000), st.integers(1, 500))
def test_a_gap_is_empty(lead: int, gap: int, tail: int) -> None:
    columns = Columns(LAYOUT)
    columns.add(block(0, lead + 1))
    columns.add(block(lead + 1 + gap, tail))
    first, got = columns.since(0)
    for k, column in enumerate(got):
        begin = (first + k) * columns.samples
        positions = np.arange(begin, begin + columns.samples)
        arrival = (positions <= lead) | (positions > lead + gap)
        assert np.isnan(column).all() == (not arrival.any())


def test_epochs_are_not_joined() -> None:
    columns = Columns(LAYOUT)
    columns.add(block(5000, 800))
    old = columns.place(5400, 0)
    columns.add(block(0, 800, epoch=1))
    assert old == 400 / columns.samples
    assert columns.place(5400, 0) == old
    assert columns.place(5400, 9) is None
    assert columns.place(0, 1) == 101.0
    _, got = columns.since(99)
    assert np.isnan(got[1]).all()
    assert not np.isnan(got[0]).any()
    assert not np.isnan(got[2]).any()


@given(st.integers(1, 400), st.integers(0, 200))
def test_the_closeup_has_every_sample_once(n: int, late: int) -> None:
    closeup = Closeup(LAYOUT)
    contact = Contact(Finger.INDEX, 1000, 1000 + late)
    predictions = False
    for first in range(0, 2000, n):
        closeup.add(block(first, n))
        if not predictions and first + n > contact.decided:
            closeup.begin(contact, 0)
            predictions = True
    tree = closeup.tree()
    samples = np.arange(1000 - round(BEFORE * RATE), 1000 + round(AFTER * RATE) + 1)
    np.testing.assert_allclose(tree["traces"][0], volts(samples), atol=6e-5)
    np.testing.assert_allclose(tree["ms"], (samples - 1000) / RATE * 1e3, atol=6e-4)


def next_pinch(feed: Feed) -> PinchDone:
    while True:
        for event in feed.update().events:
            if isinstance(event, PinchDone):
                return event


def test_a_pinch_has_the_word_that_was_said_for_it() -> None:
    feed = Feed()
    pinches = PinchRows()
    next_pinch(feed)
    finished_pinch = [next_pinch(feed) for _ in range(4)]
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
    next_pinch(feed)
    first, second, third = (next_pinch(feed) for _ in range(3))
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
