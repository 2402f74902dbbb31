"""The page shows how the answer narrows, where it ends, and what pinches of one object say."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import pytest
from page_feed import Asked
from told_events import ANSWER, DESCRIPTOR, ESTIMATE, FIRST, SECOND, numbered

from firstcontact.device import Health
from firstcontact.streaming import PageSink, PinchDone, Settled, Touched
from firstcontact.streaming._events import Case, Event, SameObject
from firstcontact.streaming._sink import Update
from firstcontact.streaming.page._state import State
from page_browser import browsing, needs_browser, text, until

TOUCHED = Touched(FIRST, first=True, epoch=0, host=0.0)
#: An answer each millisecond from 2 to 15, narrower each time; the last but one stands.
ANSWERS = tuple(
    replace(
        ANSWER,
        low=30.5 - 30 / ms,
        high=30.5 + 30 / ms,
        samples=round(4.936 * ms),
        duration=round(4.936 * ms) / 4936,
        complete=FIRST.sample + round(4.936 * ms) - 1,
    )
    for ms in range(2, 16)
)
SETTLED = Settled(FIRST, ANSWERS[-2], 1, SECOND.decided, 0)
DONE = PinchDone(1, 400, 1600, 0, (FIRST, SECOND), (), (), 4936.0, "", ANSWERS[:-1])
SAME = SameObject(1, 30.5, 22.0, 39.0, 0.9, 3, end=1600, epoch=0)


def shown(*events: Event) -> dict[str, Any]:
    """What a viewer is told of these."""
    state = State(DESCRIPTOR, {}, controls=None)
    state.take(Update((numbered(0, 1600),), events, Health(connected=True)))
    parts = state.changed({})
    assert "faults" not in parts
    return {name: json.loads(parts[name]) for name in ("now", "pinches") if name in parts}


def test_answers_come_one_by_one_and_end_where_they_stand() -> None:
    going = shown(TOUCHED, *ANSWERS[:5])["now"]
    assert [round(a["ms"]) for a in going["answers"]] == [2, 3, 4, 5, 6]
    assert going["judged"] is False
    now = shown(TOUCHED, *ANSWERS, Touched(SECOND, False, 0, 0.0), SETTLED, DONE, SAME)["now"]
    assert [round(a["ms"]) for a in now["answers"]] == list(range(2, 15))
    assert now["estimate"]["low"] == round(ANSWERS[-2].low, 2)  # of 14 ms, there after 14.1
    assert (now["judged"], now["case"], now["second"]) == (True, "IN_TIME", 14.182)
    assert now["same"] == {"value": 30.5, "low": 22.0, "high": 39.0, "pinches": 3, "told": True}


def test_a_model_of_a_window_stands_beside_it() -> None:
    now = shown(TOUCHED, *ANSWERS, SETTLED, ESTIMATE, DONE)["now"]
    assert now["estimate"]["value"] == ANSWER.value
    assert (now["window"]["value"], now["window_ms"]) == (ESTIMATE.value, 15.0)


def test_the_table_holds_what_stands() -> None:
    odd, late = replace(ANSWERS[-2], strange=True), replace(ANSWERS[-2], compute=0.05)
    each = ((late,), (odd,), ())
    rows = shown(DONE, *(replace(DONE, answers=its) for its in each))["pinches"]
    assert [row["case"] for row in rows] == [
        Case.IN_TIME.name,
        Case.TOO_LATE.name,
        Case.IN_TIME.name,
        Case.NONE.name,
    ]
    assert [row["strange"] for row in rows] == [False, False, True, False]
    assert rows[0]["estimate"]["value"] == ANSWER.value
    assert rows[3]["estimate"] is None


def test_what_was_withdrawn_altogether_is_told() -> None:
    none = Settled(FIRST, None, 2, SECOND.decided, 0, "touched before there was an answer")
    now = shown(TOUCHED, *ANSWERS[:2], none)["now"]
    assert "before there was an answer" in now["refused"]
    assert "answers" not in now


@pytest.fixture(scope="module")
def chromium(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    with browsing(tmp_path_factory.mktemp("profile")) as driver:
        yield driver


@needs_browser
def test_it_is_drawn_and_a_new_object_is_asked_for(chromium: Any) -> None:
    asked = Asked()
    page = PageSink(port=0, controls=asked, landmarks={"block 29": 29.0})
    page.open(DESCRIPTOR)
    try:
        chromium.get(page.url)
        odd = tuple(replace(a, strange=True) for a in ANSWERS)
        settled = replace(SETTLED, answer=odd[-2])
        events = (TOUCHED, *odd, Touched(SECOND, False, 0, 0.0), settled, SAME)
        page.take(Update((numbered(0, 1600),), events, Health(connected=True)))
        until(chromium, lambda d: text(d, "value") == "31")
        # It is drawn slower than it came: in the end each answer and the last are circles.
        circles = "return document.querySelectorAll('#scale circle').length"
        until(chromium, lambda d: d.execute_script(circles) == len(ANSWERS))
        until(chromium, lambda d: "2nd: 14.2 ms" in text(d, "scale"))
        assert chromium.find_element("id", "strange").is_displayed()
        assert text(chromium, "same-word") == "Same object, 3 pinches"
        alone = replace(SAME, pinches=1, told=False)
        page.take(Update((), (alone,), Health(connected=True)))
        until(chromium, lambda d: text(d, "same-word").startswith("This pinch alone"))
        chromium.find_element("id", "new-object").click()
        until(chromium, lambda d: asked.calls == ["new"])
        chromium.find_element("tag name", "body").send_keys("n")
        until(chromium, lambda d: asked.calls == ["new", "new"])
        chromium.find_element("id", "shape").send_keys("Flat")
        chromium.find_element("id", "tell-shape").click()
        until(chromium, lambda d: asked.calls[2:] == ["shape Flat"])
        until(chromium, lambda d: "flat" in text(d, "recording"))
    finally:
        page.close()


def test_what_a_window_said_stays_where_the_other_model_has_no_answer() -> None:
    none = Settled(FIRST, None, 0, SECOND.decided, 0, "samples were lost")
    assert shown(TOUCHED, ESTIMATE, none)["now"]["estimate"]["value"] == ESTIMATE.value


def test_what_was_told_of_the_shape_stands_beside_the_answer() -> None:
    assert shown(TOUCHED, *ANSWERS)["now"]["told"] == ""
    told = [replace(a, radius=0.037) for a in ANSWERS]
    assert shown(TOUCHED, *told)["now"]["told"] == "radius 37 mm"
