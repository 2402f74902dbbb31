"""The page shows how intervals narrow, where estimates end, and pooled estimates."""

from typing import Any

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
from msgspec.structs import replace
from page_feed import Requests

from firstcontact.device import Health
from firstcontact.streaming import HandPinch, ObjectEstimate, Update
from firstcontact.streaming.page.sink import PageSink
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
