"""Predictions of a device on the page: row and time of a pinch."""

from __future__ import annotations

import json
from pathlib import Path

from example_events import ANSWER, DESCRIPTOR, EVENTS, FIRST_EVENT, OF_HAND, numbered, pinch
from msgspec.structs import replace

from firstcontact.device import Health
from firstcontact.streaming import Event, HandPinch, PageSink, Update
from firstcontact.streaming.page._state import State
from page_browser import browsing, needs_browser, text, until

DONE = pinch(ANSWER)
(HAND,) = (event for event in EVENTS if isinstance(event, HandPinch))


def update(*events: Event) -> Update:
    return Update((numbered(0, 1600),), events, Health(connected=True))


def on_hand(*events: Event) -> object:
    """Return the data that the page shows about a device's predictions after these events."""
    state = State(DESCRIPTOR, {}, controls=None)
    state.take(update(*events))
    return json.loads(state.changed({}).get("on_hand", '"nothing"'))


def test_the_page_gets_the_devices_own_estimate() -> None:
    pinch = on_hand(FIRST_EVENT, DONE, HAND)
    assert isinstance(pinch, dict)
    assert pinch["final"]["available"] == OF_HAND.available
    assert pinch["final"]["compute"] == 441e-6


def test_it_is_gone_with_the_next_contact_and_absent_without_a_device() -> None:
    assert on_hand(FIRST_EVENT, DONE, HAND, FIRST_EVENT) is None
    without = on_hand(FIRST_EVENT, DONE, replace(HAND, final=None))
    assert isinstance(without, dict)
    assert without["final"] is None
    assert on_hand(FIRST_EVENT, DONE) == "nothing"


@needs_browser
def test_its_row_leaves_the_table_as_wide_as_it_was(tmp_path: Path) -> None:
    page = PageSink(port=0)
    page.open(DESCRIPTOR)
    width = "return document.querySelector('table').scrollWidth"
    room = "return document.querySelector('.pinches').clientWidth"
    try:
        with browsing(tmp_path / "profile") as driver:
            driver.get(page.url)
            page.take(update(FIRST_EVENT, ANSWER, DONE))
            until(driver, lambda d: "30" in text(d, "rows") or "31" in text(d, "rows"))
            page.take(update(HAND))
            until(driver, lambda d: "on the hand" in text(d, "rows"))
            assert driver.execute_script(width) <= driver.execute_script(room)
            assert "12.19 ms" in text(driver, "hand-times")
    finally:
        page.close()
