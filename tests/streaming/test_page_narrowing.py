"""The page shows how intervals narrow, where estimates end, and pooled estimates."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

import pytest
from example_events import (
    ANSWER,
    DESCRIPTOR,
    FIRST,
    FIRST_EVENT,
    RATE,
    SECOND,
    SECOND_EVENT,
    numbered,
    pinch,
    timed,
)
from msgspec.structs import replace
from page_feed import Requests

from firstcontact.device import Health
from firstcontact.streaming import Event, NoEstimate, ObjectEstimate, PageSink, Update
from firstcontact.streaming.page._state import State
from page_browser import browsing, needs_browser, text, until

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
COMBINED = ObjectEstimate(
    number=1, value=30.5, low=22.0, high=39.0, level=0.9, pinches=3, end=1600, epoch=0
)


def page_state(*events: Event) -> dict[str, Any]:
    """Return the page's state after these events, as a viewer receives it."""
    state = State(DESCRIPTOR, {}, controls=None)
    state.take(Update((numbered(0, 1600),), events, Health(connected=True)))
    parts = state.changed({})
    assert "faults" not in parts
    return {name: json.loads(parts[name]) for name in ("now", "pinches") if name in parts}


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


def test_a_closing_whose_estimates_were_all_withdrawn_shows_the_reason() -> None:
    none = NoEstimate(FIRST, "touched before there was an estimate", SECOND.decided, 0)
    now = page_state(FIRST_EVENT, *ESTIMATES[:2], none)["now"]
    assert now["missing"]["reason"] == none.reason
    assert now["estimates"] == []


@pytest.fixture(scope="module")
def chromium(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    with browsing(tmp_path_factory.mktemp("profile")) as driver:
        yield driver


@needs_browser
def test_it_is_drawn_and_a_new_object_is_requested(chromium: Any) -> None:
    requests = Requests()
    page = PageSink(port=0, controls=requests, landmarks={"block 29": 29.0})
    page.open(DESCRIPTOR)
    try:
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
    finally:
        page.close()


@needs_browser
def test_card_and_row_show_the_estimate_in_force_and_a_later_one_as_a_detail(
    chromium: Any,
) -> None:
    page = PageSink(port=0)
    page.open(DESCRIPTOR)
    early = timed(ESTIMATES[3], value=20.0, low=15.0, high=25.0)
    late = timed(ESTIMATES[-2], value=44.0, waited=0.02)
    try:
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
    finally:
        page.close()
