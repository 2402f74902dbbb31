"""The any-time model live: what offline gives at each millisecond, and nothing after the second."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from streams import cut, run, told

from firstcontact.contact import Detector, detect
from firstcontact.core import Block, Dataset, InputError, fingertip_layout
from firstcontact.models import InContextModel, moments, touches_of
from firstcontact.streaming import ModelWithInterval, PinchDone, Pipeline, Refused, Running, Settled
from firstcontact.streaming._events import Case

LAYOUT = fingertip_layout()
RATE = LAYOUT.rate


def blocks_of(dataset: Dataset) -> list[Block]:
    return [Block(p.data, p.first_sample, epoch) for epoch, p in enumerate(dataset.pinches)]


def frames_of(dataset: Dataset, size: int = 5) -> list[Block]:
    return [p for b in blocks_of(dataset) for p in cut(b, [*range(size, len(b.data), size)])]


def pipeline(detector: Detector, anytime: InContextModel, **more: object) -> Pipeline:
    return Pipeline(LAYOUT, detector, anytime=anytime, **more)  # type: ignore[arg-type]


def test_live_is_offline(fresh: Dataset, detector: Detector, anytime: InContextModel) -> None:
    events = run(pipeline(detector, anytime), frames_of(fresh))
    pinches = [e for e in events if isinstance(e, PinchDone)]
    assert len(pinches) == len(fresh)
    for done, pinch in zip(pinches, fresh.pinches, strict=True):
        first, second = (*detect(detector, pinch), None)[:2]
        touches, which = touches_of(Dataset((pinch,)), [first], [second])
        assert list(which) == [0]
        expected = [n for n in moments(RATE) if n <= touches.valid[0]]
        assert [e.samples for e in done.answers] == expected
        for answer in done.answers:
            offline = anytime.answers(touches.until(answer.samples))
            assert answer.value == pytest.approx(offline.values[0], abs=1e-3)
            assert answer.low == pytest.approx(offline.low[0], abs=1e-3)
            assert answer.high == pytest.approx(offline.high[0], abs=1e-3)
            assert answer.strange == offline.strange[0]
        assert done.standing is (done.answers[-1] if expected else None)


@pytest.mark.parametrize("size", [1, 5, 14, 74, 494])
def test_block_sizes_do_not_matter(
    size: int,
    fresh: Dataset,
    detector: Detector,
    models: list[ModelWithInterval],
    anytime: InContextModel,
) -> None:
    some = fresh.take([3, 4])
    whole = told(run(Pipeline(LAYOUT, detector, models, anytime=anytime), blocks_of(some)))
    pieces = frames_of(some, size)
    assert told(run(Pipeline(LAYOUT, detector, models, anytime=anytime), pieces)) == whole


@settings(max_examples=15)
@given(data=st.data())
def test_blocks_do_not_matter(
    fresh: Dataset, detector: Detector, anytime: InContextModel, data: st.DataObject
) -> None:
    some = fresh.take([0, 1, 2])
    whole = told(run(pipeline(detector, anytime), blocks_of(some)))
    pieces = []
    for block in blocks_of(some):
        edges = data.draw(st.lists(st.integers(1, len(block.data) - 1), max_size=60))
        pieces += cut(block, edges)
    assert told(run(pipeline(detector, anytime), pieces)) == whole


def test_it_stops_at_the_second_contact(
    fresh: Dataset, detector: Detector, anytime: InContextModel
) -> None:
    events = run(pipeline(detector, anytime), frames_of(fresh))
    short = withdrawn = 0
    for done in (e for e in events if isinstance(e, PinchDone)):
        its = [e for e in events if getattr(e, "epoch", None) == done.epoch]
        answers = [e for e in its if isinstance(e, Running)]
        settled = [e for e in its if isinstance(e, Settled)]
        assert settled
        assert settled[-1].answer == done.standing
        first, *others = done.contacts
        if not others:
            continue
        offset = others[0].sample - first.sample
        assert all(e.samples <= offset for e in done.answers)
        assert all(e.complete <= others[0].decided for e in answers)
        assert settled[-1].withdrawn == len(answers) - len(done.answers)
        withdrawn += settled[-1].withdrawn
        short += offset < moments(RATE)[-1]
    # Offsets of these pinches are such that the second contact cuts some short.
    assert short > 0
    assert withdrawn > 0


def test_in_hindsight_all_delays_count(
    fresh: Dataset, detector: Detector, anytime: InContextModel
) -> None:
    ticks = iter(range(10**9))
    slow = pipeline(detector, anytime, clock=lambda: next(ticks) / RATE)
    cases = set()
    for done in run(slow, frames_of(fresh)):
        if isinstance(done, PinchDone) and done.answers and len(done.contacts) > 1:
            out = [e.contact.sample + e.after(RATE) * RATE for e in done.answers]
            early = [sample < done.contacts[1].sample for sample in out]
            assert [done.case_of(e) is Case.IN_TIME for e in done.answers] == early
            assert done.case is (Case.IN_TIME if any(early) else Case.TOO_LATE)
            cases.add(done.case)
    assert cases


def test_what_stands_without_a_second_contact_is_the_longest(
    fresh: Dataset, detector: Detector, anytime: InContextModel
) -> None:
    pinch = fresh.pinches[0]
    other = pinch.truth[0].finger
    assert other is not None
    data = np.array(pinch.data)
    column = LAYOUT.columns(LAYOUT.vibration[0].kind, other.other)
    data[:, column] = data[:1, column]
    events = run(pipeline(detector, anytime), [Block(data, pinch.first_sample)])
    (done,) = [e for e in events if isinstance(e, PinchDone)]
    assert len(done.contacts) == 1
    assert [e.samples for e in done.answers] == list(moments(RATE))
    assert (done.case, done.available) == (Case.IN_TIME, done.standing)
    (settled,) = [e for e in events if isinstance(e, Settled)]
    assert settled.answer == done.standing


def test_a_closing_that_breaks_off_keeps_what_was_told(
    fresh: Dataset, detector: Detector, anytime: InContextModel
) -> None:
    pinch = fresh.pinches[0]
    first = detect(detector, pinch)[0]
    end = first.decided - pinch.first_sample + 12
    events = run(pipeline(detector, anytime), [Block(pinch.data[:end], pinch.first_sample)])
    (settled,) = [e for e in events if isinstance(e, Settled)]
    (done,) = [e for e in events if isinstance(e, PinchDone)]
    assert settled.answer == done.standing is not None
    assert done.refused == ""


@settings(max_examples=15)
@given(data=st.data())
def test_every_closing_with_a_contact_settles_whatever_is_lost(
    fresh: Dataset, detector: Detector, anytime: InContextModel, data: st.DataObject
) -> None:
    blocks = blocks_of(fresh.take([0, 1, 2]))
    kept = []
    for block in blocks:
        lost, missing = data.draw(st.integers(600, 900)), data.draw(st.integers(1, 120))
        kept += [
            Block(block.data[:lost], block.first_sample, block.epoch),
            Block(block.data[lost + missing :], block.first_sample + lost + missing, block.epoch),
        ]
    events = run(pipeline(detector, anytime), kept)
    for done in (e for e in events if isinstance(e, PinchDone)):
        settled = [e for e in events if isinstance(e, Settled) and e.contact == done.contacts[0]]
        assert settled
        assert settled[-1].answer == done.standing
        assert bool(done.answers) is (settled[-1].reason == "")
        assert done.answers or done.refused


def test_an_answer_that_is_no_number_is_refused(
    fresh: Dataset, detector: Detector, anytime: InContextModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = pipeline(detector, anytime)
    answers = type(anytime).answers
    monkeypatch.setattr(
        type(anytime),
        "answers",
        lambda *a: replace(answers(*a), values=np.full(len(a[1]), np.nan)),
    )
    events = run(asked, blocks_of(fresh.take([0])))
    assert not [e for e in events if isinstance(e, Running)]
    (settled,) = [e for e in events if isinstance(e, Settled)]
    assert settled.answer is None
    (refused,) = [e for e in events if isinstance(e, Refused)]
    assert refused.reason == "the model's answer is no finite number"
    (done,) = [e for e in events if isinstance(e, PinchDone)]
    assert (done.standing, done.refused) == (None, refused.reason)


def test_a_stream_at_another_rate_is_refused(detector: Detector, anytime: InContextModel) -> None:
    with pytest.raises(InputError, match="any-time model takes samples at 4936 Hz"):
        Pipeline(replace(LAYOUT, rate=8000.0), detector, anytime=anytime)


def test_the_ledger_counts_pinches_answered_in_time(
    fresh: Dataset, detector: Detector, anytime: InContextModel
) -> None:
    asked = pipeline(detector, anytime, clock=lambda: 0.0)
    pinches = [e for e in run(asked, frames_of(fresh)) if isinstance(e, PinchDone)]
    figures = asked.ledger.summary()
    assert figures["pinches"] == len(pinches)
    assert figures["in_time"] == sum(d.case is Case.IN_TIME for d in pinches)
    assert figures["signal_max"] == max(d.standing.duration for d in pinches if d.standing)


def test_a_told_shape_is_the_models_input_from_the_next_closing_on(
    fresh: Dataset, detector: Detector, anytime: InContextModel
) -> None:
    asked = pipeline(detector, anytime)
    first, second = blocks_of(fresh.take([0, 1]))
    events = list(asked.update(first, 0.0))
    asked.radius = np.inf
    events += list(asked.update(second, 0.0)) + asked.finish()
    done = [e for e in events if isinstance(e, PinchDone)]
    for its, pinch, radius in zip(done, fresh.pinches[:2], (np.nan, np.inf), strict=True):
        assert its.standing is not None
        assert its.standing.radius == (None if np.isnan(radius) else radius)
        touches, _ = touches_of(Dataset((pinch,)), its.contacts[:1], [None])
        touches = replace(touches, radii=np.array([radius])).until(its.standing.samples)
        assert its.standing.value == pytest.approx(anytime.answers(touches).values[0], abs=1e-3)
