"""In time means available before the second contact: on the page, in JSON, in text and counted."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from streams import cut
from told_events import ANSWER, DESCRIPTOR, ESTIMATE, FIRST, SECOND, numbered

from firstcontact.contact import Detector
from firstcontact.core import Block, Dataset
from firstcontact.device import Health
from firstcontact.models import InContextModel
from firstcontact.streaming import (
    Estimated,
    ModelWithInterval,
    PinchDone,
    Pipeline,
    Running,
    Touched,
    ledger_lines,
)
from firstcontact.streaming._event_json import of_event
from firstcontact.streaming._events import Case
from firstcontact.streaming._ledger import Ledger
from firstcontact.streaming._sink import Update
from firstcontact.streaming._text import pinch_line
from firstcontact.streaming.page._state import State

RATE = DESCRIPTOR.layout.rate
DONE = PinchDone(1, 400, 1600, 0, (FIRST, SECOND), (), (), RATE)
TOUCHED = Touched(FIRST, first=True, epoch=0, host=0.0)
seconds = st.floats(0, 0.08)
times = st.fixed_dictionaries(
    {
        "complete": st.integers(FIRST.sample, FIRST.sample + 100),
        "waited": seconds,
        "transport": seconds,
        "compute": seconds,
    }
)
pinches = st.builds(
    lambda offset, answers, estimates, real_time: replace(
        DONE,
        contacts=(FIRST,) if offset is None else (FIRST, replace(SECOND, sample=510 + offset)),
        answers=tuple(replace(ANSWER, **t) for t in answers),
        estimates=tuple(replace(ESTIMATE, **t) for t in estimates),
        real_time=real_time,
    ),
    st.none() | st.integers(-5, 400),
    st.lists(times, max_size=4),
    st.lists(times, max_size=2),
    st.sampled_from((True, True, True, False)),
)


def shown(*events: Any) -> dict[str, Any]:
    """What the page is told."""
    state = State(DESCRIPTOR, {}, controls=None)
    state.take(Update((numbered(0, 1600),), events, Health(connected=True)))
    return {name: json.loads(part) for name, part in state.changed({}).items() if part}


def truth(done: PinchDone) -> str | None:
    """The verdict, reckoned here."""
    told = (*done.answers, *done.estimates)
    if not told:
        return "NONE"
    if not done.real_time:
        return None
    if len(done.contacts) == 1:
        return "IN_TIME"
    second = (done.contacts[1].sample - FIRST.sample) / RATE
    after = [(e.complete - FIRST.sample) / RATE + e.waited + e.transport + e.compute for e in told]
    return "IN_TIME" if min(after) < second else "TOO_LATE"


@settings(max_examples=200)
@given(done=pinches)
def test_page_text_and_json_say_the_same_and_never_praise_what_came_late(done: PinchDone) -> None:
    """No row reads: available 70 ms after the first contact, second after 5.1 ms, in time."""
    case = truth(done)
    parts = shown(TOUCHED, *done.answers, *done.estimates, done)
    (row,) = parts["pinches"]
    line, tree, now = pinch_line(done), of_event(done), parts["now"]
    assert row["case"] == case
    assert tree["case"] == (None if case is None else case.lower())
    if case == "IN_TIME":
        assert row["estimate"] is not None
        assert row["offset"] is None or row["ms"] <= row["offset"]
        assert tree["available"] is not None
        words = re.search(r"at (-?[\d.]+) ms(, out of range)?, in time", line)
        assert words is not None
        second = re.search(r"second after (-?[\d.]+) ms", line)
        assert second is None or float(words[1]) <= float(second[1])
    else:
        assert tree["available"] is None
        assert "in time" not in line.replace("no estimate in time", "")
        assert (row["estimate"] is None) is (case in ("TOO_LATE", "NONE"))
    if case == "TOO_LATE":
        assert "no estimate in time" in line
        assert row["later"]["ms"] >= row["offset"]
    if now.get("judged"):
        assert (now["case"], now["ms"], now["offset"]) == (case, row["ms"], row["offset"])
        assert case != "IN_TIME" or now["estimate"] == row["estimate"]


@settings(max_examples=50)
@given(done=st.lists(pinches, max_size=6))
def test_the_summary_counts_each_pinch_once(done: list[PinchDone]) -> None:
    ledger = Ledger(RATE)
    for pinch in done:
        for answer in pinch.answers:
            ledger.tell(answer)
        ledger.close(pinch)
    figures = ledger.summary()
    cases = [truth(d) for d in done]
    for name in ("IN_TIME", "TOO_LATE", "NONE"):
        assert figures[name.lower()] == cases.count(name)
    said = "\n".join(ledger_lines(figures, 1.0, 0.1))
    numbers = re.search(r"(\d+) pinches: (\d+) .* in time, (\d+) too late, (\d+) without", said)
    assert numbers is not None
    if None not in cases:
        assert int(numbers[1]) == sum(map(int, numbers.groups()[1:])) == len(done)


def test_the_row_that_misled_says_so() -> None:
    """Its samples lay before the second contact, and nobody had the estimate by then."""
    second = replace(SECOND, sample=FIRST.sample + 25)
    samples = replace(ANSWER, samples=20, complete=FIRST.sample + 20, waited=0.066)
    late = replace(DONE, contacts=(FIRST, second), answers=(samples,))
    (row,) = shown(TOUCHED, late)["pinches"]
    assert (row["case"], row["estimate"], row["ms"]) == ("TOO_LATE", None, None)
    assert row["later"]["ms"] == pytest.approx(70.352, abs=0.001)
    early = replace(samples, waited=0.0, value=12.0)
    (row,) = shown(TOUCHED, replace(late, answers=(early, samples)))["pinches"]
    assert (row["case"], row["estimate"]["value"]) == ("IN_TIME", 12.0)
    assert row["ms"] < row["offset"] < row["later"]["ms"]


def test_before_a_pinch_is_over_no_verdict_is_given() -> None:
    assert shown(TOUCHED, ANSWER)["now"]["judged"] is False
    assert shown(TOUCHED, ESTIMATE)["now"]["judged"] is False


@settings(max_examples=20)
@given(data=st.data())
def test_it_is_the_hosts_clock_that_decides(
    fresh: Dataset,
    detector: Detector,
    models: list[ModelWithInterval],
    anytime: InContextModel,
    data: st.DataObject,
) -> None:
    """Blocks that are held up, and a slow computer, count: all by the clock of the host."""
    pinch = fresh.pinches[data.draw(st.integers(0, 4))]
    edges = data.draw(st.lists(st.integers(1, len(pinch.data) - 1), max_size=40))
    compute = data.draw(st.sampled_from((0.0, 0.001, 0.02)))
    now = 0.0
    pipeline = Pipeline(
        DESCRIPTOR.layout, detector, models, clock=lambda: now + compute, anytime=anytime
    )
    taken, free = 1000.0, 0.0  # host time of sample 0, and when the line is free again
    found = []
    for block in cut(Block(pinch.data, pinch.first_sample), edges):
        held = 0.0 if block.first_sample == pinch.first_sample else data.draw(seconds)
        now = max(free, taken + (block.end - 1) / RATE + held)
        free = now
        found += list(pipeline.update(block, now))
    found += pipeline.finish()
    (done,) = [e for e in found if isinstance(e, PinchDone)]
    for e in (*done.answers, *done.estimates):
        assert isinstance(e, Running | Estimated)
        assert e.host == pytest.approx(taken + e.contact.sample / RATE + e.after(RATE), abs=1e-6)
        if done.second is not None:
            touched = taken + done.second.sample / RATE
            assert done.case_of(e) is (Case.IN_TIME if e.host < touched - 1e-9 else Case.TOO_LATE)


def test_faster_than_real_time_nothing_is_said_to_be_in_time(
    fresh: Dataset, detector: Detector, anytime: InContextModel
) -> None:
    pipeline = Pipeline(DESCRIPTOR.layout, detector, anytime=anytime, real_time=False)
    pinch = fresh.pinches[0]
    found = [*pipeline.update(Block(pinch.data, pinch.first_sample), 0.0), *pipeline.finish()]
    (done,) = [e for e in found if isinstance(e, PinchDone)]
    assert (done.case, done.available) == (None, None)
    (row,) = shown(*found)["pinches"]
    assert row["case"] is None
    assert row["estimate"] is not None
    assert row["ms"] is None
    assert " at " not in pinch_line(done)
    said = "\n".join(ledger_lines(pipeline.ledger.summary(), 1.0, 0.1, speed=4.0))
    assert "what was in time" in said
    assert "too late" not in said
