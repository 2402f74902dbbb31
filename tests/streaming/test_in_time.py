""" "In time" means available before the second contact: on the page, in JSON, text and counts."""

import json
import math
import re

import pytest
from example_events import ANSWER, DESCRIPTOR, FIRST, FIRST_EVENT, SECOND, page_state, pinch, timed
from hypothesis import given, settings
from hypothesis import strategies as st
from streams import cut

from firstcontact.contact import Detector
from firstcontact.core import Block, Contact, Dataset
from firstcontact.models import WindowPredictor
from firstcontact.models.anytime import PredictorLadder
from firstcontact.models.rig.rig_model import RigModel
from firstcontact.streaming import PinchDone, Pipeline
from firstcontact.streaming.json_lines import json_line
from firstcontact.streaming.ledger import Ledger, delay_cause, ledger_lines
from firstcontact.streaming.text import pinch_line

RATE = DESCRIPTOR.layout.rate
seconds = st.floats(0, 0.08)
times = st.fixed_dictionaries(
    {
        "complete": st.integers(FIRST.sample, FIRST.sample + 100),
        "waited": seconds,
        "transport": seconds,
        "compute": seconds,
    }
)


def contacts_with_offset(offset: int | None) -> tuple[Contact, ...]:
    """Return the contacts of a pinch with this offset, in samples."""
    if offset is None:
        return (FIRST,)
    return FIRST, Contact(SECOND.finger, FIRST.sample + offset, SECOND.decided)


pinches = st.builds(
    lambda offset, estimates, real_time: pinch(
        *(timed(ANSWER, **t) for t in estimates),
        contacts=contacts_with_offset(offset),
        real_time=real_time,
    ),
    st.none() | st.integers(-5, 400),
    st.lists(times, max_size=5),
    st.sampled_from((True, True, True, False)),
)


def truth(finished_pinch: PinchDone) -> str | None:
    """Return the right verdict on the pinch's estimate, computed from its times by the test."""
    if not finished_pinch.estimates:
        return "none"
    if not finished_pinch.real_time:
        return None
    if len(finished_pinch.contacts) == 1:
        return "in_time"
    second = (finished_pinch.contacts[1].sample - FIRST.sample) / RATE
    current = [
        (e.complete - FIRST.sample) / RATE + e.waited + e.transport + e.compute
        for e in finished_pinch.estimates
    ]
    return "in_time" if min(current) < second else "too_late"


@settings(max_examples=200)
@given(finished_pinch=pinches)
def test_page_text_and_json_say_the_same_and_never_praise_what_came_late(
    finished_pinch: PinchDone,
) -> None:
    """An estimate that is available after 70 ms is too late for a second contact after 5.1 ms."""
    case = truth(finished_pinch)
    parts = page_state(FIRST_EVENT, *finished_pinch.estimates, finished_pinch)
    ((row,), now) = parts["pinches"], parts["now"]
    line, tree = pinch_line(finished_pinch), json.loads(json_line(finished_pinch))
    early = [e["available"] for e in tree["estimates"] if e["in_time"]]
    assert row["pinch"]["verdict"] == tree["verdict"] == now["pinch"]["verdict"] == case
    assert row["pinch"] == now["pinch"]
    of_row = [e for e in row["pinch"]["estimates"] if e["in_time"]]
    if case == "in_time":
        assert finished_pinch.offset is None or max(early) < finished_pinch.offset
        assert of_row[-1]["available"] == early[-1]
        words = re.search(r"at (-?[\d.]+) ms(, out of range)?, in time", line)
        assert words is not None
        second = re.search(r"second after (-?[\d.]+) ms", line)
        assert second is None or float(words[1]) <= float(second[1])
    else:
        assert early == of_row == []
        assert "in time" not in line.replace("no estimate in time", "")
    if case == "too_late":
        assert "no estimate in time" in line
        assert row["pinch"]["estimates"][-1]["available"] >= finished_pinch.offset


@settings(max_examples=50)
@given(finished_pinch=st.lists(pinches, max_size=6))
def test_the_summary_counts_each_pinch_once(finished_pinch: list[PinchDone]) -> None:
    ledger = Ledger(RATE)
    for one in finished_pinch:
        for estimate in one.estimates:
            ledger.add(estimate)
        ledger.close(one)
    figures = ledger.summary()
    cases = [truth(d) for d in finished_pinch]
    for name in ("in_time", "too_late", "none"):
        assert figures[name] == cases.count(name)
    text = "\n".join(ledger_lines(figures))
    numbers = re.search(r"(\d+) of (\d+) pinches.*; (\d+) too late, (\d+) without", text)
    assert numbers is not None
    if None not in cases:
        in_force, pinches, *remaining = map(int, numbers.groups())
        assert in_force + sum(remaining) == pinches == len(finished_pinch)


@settings(max_examples=20)
@given(data=st.data())
def test_it_is_the_hosts_clock_that_decides(
    fresh: Dataset,
    detector: Detector,
    models: list[WindowPredictor],
    anytime: RigModel,
    data: st.DataObject,
) -> None:
    """Delays of blocks and of computing are included, by the host's clock."""
    one = fresh.pinches[data.draw(st.integers(0, 4))]
    edges = data.draw(st.lists(st.integers(1, len(one.data) - 1), max_size=40))
    compute = data.draw(st.sampled_from((0.0, 0.001, 0.02)))
    now = 0.0
    predictor = data.draw(st.sampled_from((PredictorLadder(models), anytime)))
    pipeline = Pipeline(DESCRIPTOR.layout, detector, predictor, clock=lambda: now + compute)
    taken, free = 1000.0, 0.0  # host time of sample 0, and when the line is free again
    collected = []
    for block in cut(Block(one.data, one.first_sample), edges):
        held_out = 0.0 if block.first_sample == one.first_sample else data.draw(seconds)
        now = max(free, taken + (block.end - 1) / RATE + held_out)
        free = now
        collected += list(pipeline.update(block, now))
    collected += pipeline.finish()
    (finished_pinch,) = [e for e in collected if isinstance(e, PinchDone)]
    offset = finished_pinch.offset
    for e in finished_pinch.estimates[:1]:
        punctual = e.available - (e.waited + e.transport + e.compute)
        is_delayed = offset is not None and punctual < offset <= e.available
        assert bool(finished_pinch.delay_cause) == is_delayed
    for e in finished_pinch.estimates:
        assert e.host == pytest.approx(taken + e.contact.sample / RATE + e.available, abs=1e-6)
        if finished_pinch.second is not None:
            assert e.in_time is (e.host < taken + finished_pinch.second.sample / RATE - 1e-9)


def test_each_cause_of_a_delay_has_its_own_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("os.getloadavg", lambda: (0.5, 0.5, 0.5))
    punctual, late, none = {"waited": 0.0, "transport": 0.0, "compute": 0.0}, 0.03, math.nan
    offset = timed(ANSWER, **punctual).available + 0.01
    cases = (
        ("waited", 0.0, 0.0), ("transport", 0.0, 0.0), ("compute", 0.0, 0.0),
        ("transport", late, 0.0), ("compute", 0.0, late), ("transport", none, late),
    )  # fmt: skip
    sentences = {
        delay_cause(timed(ANSWER, **punctual | {part: late}), offset, queued, stalled)
        for part, queued, stalled in cases
    }
    assert len(sentences) == len(cases)
    assert all("30.0 ms" in sentence for sentence in sentences)
    for other in (None, offset - 0.02, offset + 0.1):  # alone, too early, and still in time
        assert not delay_cause(timed(ANSWER, **punctual | {"compute": late}), other, late, late)


@pytest.mark.parametrize(("closings", "is_told"), [(0, False), (2, False), (3, True), (36, True)])
def test_closings_without_any_contact_are_explained(closings: int, is_told: bool) -> None:
    ledger = Ledger(RATE)
    ledger.closings = closings
    for speed in (1.0, 8.0):
        text = "\n".join(ledger_lines(ledger.summary(), speed=speed))
        assert ("firstcontact check" in text) == is_told
