"""The network live: as offline at each millisecond, and nothing after the second contact."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from streams import blocks_of, cut, facts, frames_of, run

from firstcontact.contact import Detector, detect
from firstcontact.core import Block, Dataset, InputError, fingertip_layout
from firstcontact.models import InContextModel, Model, WindowPredictor, moments, touches_of
from firstcontact.models import NetworkPredictor as NetworkEntry
from firstcontact.streaming import (
    Estimate,
    NetworkPredictor,
    NoEstimate,
    PinchDone,
    Pipeline,
    Verdict,
    predictor_of,
)

LAYOUT = fingertip_layout()
RATE = LAYOUT.rate


def pipeline(detector: Detector, anytime: InContextModel, **more: object) -> Pipeline:
    return Pipeline(LAYOUT, detector, NetworkPredictor(anytime), **more)  # type: ignore[arg-type]


def samples_of(estimate: Estimate) -> int:
    return round(estimate.elapsed * RATE)


def test_live_is_offline(fresh: Dataset, detector: Detector, anytime: InContextModel) -> None:
    events = run(pipeline(detector, anytime), frames_of(fresh))
    pinches = [e for e in events if isinstance(e, PinchDone)]
    assert len(pinches) == len(fresh)
    for done, pinch in zip(pinches, fresh.pinches, strict=True):
        first, second = (*detect(detector, pinch), None)[:2]
        touches, which = touches_of(Dataset((pinch,)), [first], [second])
        assert list(which) == [0]
        expected = [n for n in moments(RATE) if n <= touches.valid[0]]
        assert [samples_of(e) for e in done.estimates] == expected
        assert [e.final for e in done.estimates] == [n == expected[-1] for n in expected]
        for estimate in done.estimates:
            offline = anytime.predict(touches.until(samples_of(estimate)))
            assert estimate.value == pytest.approx(offline.value[0], abs=1e-3)
            assert estimate.low == pytest.approx(offline.low[0], abs=1e-3)
            assert estimate.high == pytest.approx(offline.high[0], abs=1e-3)
            assert estimate.out_of_range == offline.out_of_range[0]


def test_live_is_what_the_model_predicts(
    fresh: Dataset, detector: Detector, anytime: InContextModel, models: list[WindowPredictor]
) -> None:
    """Of a model that has both, the network predicts, unless another estimator is named."""
    model = Model(detector, (*models, NetworkEntry(anytime)))
    for estimator in (None, "svm"):
        predictor = predictor_of(model, estimator)
        done = [
            e
            for e in run(Pipeline(LAYOUT, detector, predictor), blocks_of(fresh))
            if isinstance(e, PinchDone)
        ]
        compared = 0
        for live, pinch in zip(done, fresh.pinches, strict=True):
            for e in live.estimates:
                offline = model.predict(
                    Dataset((pinch,)), e.elapsed + 9e-5, live.contacts[:1], estimator=estimator
                )
                if not offline.elapsed[0] >= e.elapsed - 1e-4:
                    continue  # the pinch knows its second contact, which was detected later
                assert e.value == pytest.approx(offline.value[0], abs=5e-3)
                compared += 1
        assert compared > len(fresh)
    with pytest.raises(InputError) as refused:
        predictor_of(model, "cnn")
    assert refused.value.parameter == "estimator"


@pytest.mark.parametrize("size", [1, 5, 14, 74, 494])
def test_block_sizes_do_not_matter(
    size: int, fresh: Dataset, detector: Detector, anytime: InContextModel
) -> None:
    some = fresh.take([3, 4])
    whole = facts(run(pipeline(detector, anytime), blocks_of(some)))
    assert facts(run(pipeline(detector, anytime), frames_of(some, size))) == whole


@settings(max_examples=15)
@given(data=st.data())
def test_blocks_do_not_matter(
    fresh: Dataset, detector: Detector, anytime: InContextModel, data: st.DataObject
) -> None:
    some = fresh.take([0, 1, 2])
    whole = facts(run(pipeline(detector, anytime), blocks_of(some)))
    pieces = []
    for block in blocks_of(some):
        edges = data.draw(st.lists(st.integers(1, len(block.data) - 1), max_size=60))
        pieces += cut(block, edges)
    assert facts(run(pipeline(detector, anytime), pieces)) == whole


def test_it_stops_at_the_second_contact(
    fresh: Dataset, detector: Detector, anytime: InContextModel
) -> None:
    events = run(pipeline(detector, anytime), frames_of(fresh))
    short = withdrawn = 0
    for done in (e for e in events if isinstance(e, PinchDone)):
        its = [e for e in events if getattr(e, "epoch", None) == done.epoch]
        running = [e for e in its if isinstance(e, Estimate) and not e.final]
        ends = [
            e for e in its if isinstance(e, NoEstimate) or (isinstance(e, Estimate) and e.final)
        ]
        assert ends
        if done.final is None:
            assert isinstance(ends[-1], NoEstimate)
        else:
            assert isinstance(ends[-1], Estimate)
            assert ends[-1].value == done.final.value
        first, *others = done.contacts
        if not others:
            continue
        offset = others[0].sample - first.sample
        assert all(samples_of(e) <= offset for e in done.estimates)
        assert all(e.complete <= others[0].decided for e in running)
        withdrawn += len(running) - len(done.estimates)
        short += offset < moments(RATE)[-1]
    # Offsets of these pinches are such that the second contact cuts some short.
    assert short > 0
    assert withdrawn > 0


def test_in_hindsight_all_delays_count(
    fresh: Dataset, detector: Detector, anytime: InContextModel
) -> None:
    ticks = iter(range(10**9))
    slow = pipeline(detector, anytime, clock=lambda: next(ticks) / RATE)
    verdicts = set()
    for done in run(slow, frames_of(fresh)):
        if isinstance(done, PinchDone) and done.estimates and done.second is not None:
            out = [e.contact.sample + e.available * RATE for e in done.estimates]
            early = [sample < done.second.sample for sample in out]
            assert [e.in_time for e in done.estimates] == early
            assert done.verdict is (Verdict.IN_TIME if any(early) else Verdict.TOO_LATE)
            verdicts.add(done.verdict)
    assert verdicts


def test_the_final_one_without_a_second_contact_is_the_longest(
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
    assert [samples_of(e) for e in done.estimates] == list(moments(RATE))
    assert (done.verdict, done.in_force) == (Verdict.IN_TIME, done.final)
    (final,) = [e for e in events if isinstance(e, Estimate) and e.final]
    assert done.final is not None
    # Nothing is known of a second contact when it is told.
    assert (final.value, final.in_time, done.final.in_time) == (done.final.value, None, True)


def test_a_closing_that_breaks_off_keeps_its_estimates(
    fresh: Dataset, detector: Detector, anytime: InContextModel
) -> None:
    pinch = fresh.pinches[0]
    first = detect(detector, pinch)[0]
    end = first.decided - pinch.first_sample + 12
    events = run(pipeline(detector, anytime), [Block(pinch.data[:end], pinch.first_sample)])
    (final,) = [e for e in events if isinstance(e, Estimate) and e.final]
    (done,) = [e for e in events if isinstance(e, PinchDone)]
    assert done.final is not None
    assert final.value == done.final.value
    assert done.reason == ""


@settings(max_examples=15)
@given(data=st.data())
def test_every_closing_with_a_contact_ends_with_an_estimate_or_a_reason(
    fresh: Dataset, detector: Detector, anytime: InContextModel, data: st.DataObject
) -> None:
    kept = []
    for block in blocks_of(fresh.take([0, 1, 2])):
        lost, missing = data.draw(st.integers(600, 900)), data.draw(st.integers(1, 120))
        kept += [
            Block(block.data[:lost], block.first_sample, block.epoch),
            Block(block.data[lost + missing :], block.first_sample + lost + missing, block.epoch),
        ]
    events = run(pipeline(detector, anytime), kept)
    for done in (e for e in events if isinstance(e, PinchDone)):
        ends = [
            e
            for e in events
            if (isinstance(e, NoEstimate) or (isinstance(e, Estimate) and e.final))
            and e.contact == done.contacts[0]
        ]
        assert ends
        last = ends[-1]
        if isinstance(last, NoEstimate):
            assert (done.estimates, done.reason) == ((), last.reason)
            assert last.reason
        else:
            assert done.final is not None
            assert (done.final.value, done.reason) == (last.value, "")


def test_a_prediction_that_is_no_number_is_refused(
    fresh: Dataset, detector: Detector, anytime: InContextModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    live = pipeline(detector, anytime)
    predict = type(anytime).predict
    monkeypatch.setattr(
        type(anytime),
        "predict",
        lambda *a: replace(predict(*a), value=np.full(len(a[1]), np.nan)),
    )
    events = run(live, blocks_of(fresh.take([0])))
    assert not [e for e in events if isinstance(e, Estimate)]
    (refused,) = [e for e in events if isinstance(e, NoEstimate)]
    assert "finite" in refused.reason
    (done,) = [e for e in events if isinstance(e, PinchDone)]
    assert (done.final, done.reason) == (None, refused.reason)


def test_a_stream_at_another_rate_is_refused(detector: Detector, anytime: InContextModel) -> None:
    with pytest.raises(InputError, match="4936 Hz"):
        Pipeline(replace(LAYOUT, rate=8000.0), detector, NetworkPredictor(anytime))


def test_the_ledger_counts_pinches_in_time(
    fresh: Dataset, detector: Detector, anytime: InContextModel
) -> None:
    live = pipeline(detector, anytime, clock=lambda: 0.0)
    pinches = [e for e in run(live, frames_of(fresh)) if isinstance(e, PinchDone)]
    figures = live.ledger.summary()
    assert figures["pinches"] == len(pinches)
    assert figures["in_time"] == sum(d.verdict is Verdict.IN_TIME for d in pinches)
    assert figures["signal_max"] == max(d.final.elapsed for d in pinches if d.final)


def test_a_shape_is_the_models_input_from_the_next_closing_on(
    fresh: Dataset, detector: Detector, anytime: InContextModel
) -> None:
    live = pipeline(detector, anytime)
    first, second = blocks_of(fresh.take([0, 1]))
    events = list(live.update(first, 0.0))
    live.radius = np.inf
    events += list(live.update(second, 0.0)) + live.finish()
    done = [e for e in events if isinstance(e, PinchDone)]
    for its, pinch, radius in zip(done, fresh.pinches[:2], (np.nan, np.inf), strict=True):
        assert its.final is not None
        assert its.final.shape == ("" if np.isnan(radius) else "flat")
        touches, _ = touches_of(Dataset((pinch,)), its.contacts[:1], [None])
        touches = replace(touches, radii=np.array([radius])).until(samples_of(its.final))
        assert its.final.value == pytest.approx(anytime.predict(touches).value[0], abs=1e-3)
