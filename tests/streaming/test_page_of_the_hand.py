"""What a device that answers by itself told of a pinch, on the page: its row and its time."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

from told_events import ANSWER, DESCRIPTOR, EVENTS, FIRST, SECOND, numbered

from firstcontact.device import Health
from firstcontact.streaming import PageSink, PinchDone, Touched
from firstcontact.streaming._events import Event, HandPinch
from firstcontact.streaming._sink import Update
from firstcontact.streaming.page._state import State
from page_browser import browsing, needs_browser, text, until

TOUCHED = Touched(FIRST, first=True, epoch=0, host=0.0)
DONE = PinchDone(1, 400, 1600, 0, (FIRST, SECOND), (), (), 4936.0, "", (ANSWER,))
(HAND,) = (event for event in EVENTS if isinstance(event, HandPinch))


def told(*events: Event) -> Update:
    return Update((numbered(0, 1600),), events, Health(connected=True))


def on_hand(*events: Event) -> object:
    """What a viewer is told of the hand's time."""
    state = State(DESCRIPTOR, {}, controls=None)
    state.take(told(*events))
    return json.loads(state.changed({}).get("on_hand", '"nothing"'))


def test_its_time_is_the_signal_and_the_arithmetic() -> None:
    stands = HAND.standing
    assert stands is not None
    time = on_hand(TOUCHED, DONE, HAND)
    assert isinstance(time, dict)
    assert time["signal"] == round(1e3 * (568 - 510) / DESCRIPTOR.layout.rate, 3)
    assert time["compute"] == 0.441
    assert abs(time["total"] - time["signal"] - time["compute"]) < 0.0011


def test_it_is_gone_with_the_next_contact_and_absent_without_an_answer() -> None:
    assert on_hand(TOUCHED, DONE, HAND, TOUCHED) is None
    assert on_hand(TOUCHED, DONE, replace(HAND, standing=None)) is None
    assert on_hand(TOUCHED, DONE) == "nothing"


@needs_browser
def test_its_row_leaves_the_table_as_wide_as_it_was(tmp_path: Path) -> None:
    page = PageSink(port=0)
    page.open(DESCRIPTOR)
    width = "return document.querySelector('table').scrollWidth"
    room = "return document.querySelector('.pinches').clientWidth"
    try:
        with browsing(tmp_path / "profile") as driver:
            driver.get(page.url)
            page.take(told(TOUCHED, ANSWER, DONE))
            until(driver, lambda d: "30" in text(d, "rows") or "31" in text(d, "rows"))
            page.take(told(HAND))
            until(driver, lambda d: "on the hand" in text(d, "rows"))
            assert driver.execute_script(width) <= driver.execute_script(room)
            assert "12.19 ms" in text(driver, "hand-times")
    finally:
        page.close()
