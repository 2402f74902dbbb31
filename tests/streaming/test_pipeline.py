"""Live gives what offline gives, bit for bit, whatever the blocks."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from streams import cut, offline, run, told

from firstcontact.contact import Detector, ThresholdDetector
from firstcontact.core import (
    Block,
    Calibration,
    Dataset,
    Finger,
    InputError,
    VibrationCalibration,
    fingertip_layout,
)
from firstcontact.streaming import (
    Estimated,
    ModelWithInterval,
    PinchDone,
    Pipeline,
    Refused,
    Touched,
)
from firstcontact.streaming._events import Case

LAYOUT = fingertip_layout()


def blocks_of(dataset: Dataset) -> list[Block]:
    """Each pinch an epoch, as a simulated recording has them."""
    return [Block(p.data, p.first_sample, epoch) for epoch, p in enumerate(dataset.pinches)]


def test_an_answer_that_is_not_finite_is_refused_aloud(
    fresh: Dataset,
    detector: Detector,
    models: list[ModelWithInterval],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Weights can overflow for one window and not for another: the page must hear of it."""
    model = models[1].model
    pipeline = Pipeline(LAYOUT, detector, [models[1]])  # has made its rehearsal
    monkeypatch.setattr(type(model), "output", lambda self, window: np.full(1, np.nan))
    events = run(pipeline, blocks_of(fresh.take([0])))
    assert not [e for e in events if isinstance(e, Estimated)]
    (refused,) = [e for e in events if isinstance(e, Refused)]
    assert "not a finite number" in refused.reason
    with pytest.raises(InputError, match="not a finite number"):
        Pipeline(LAYOUT, detector, [models[1]])  # one that never answers is not begun with


def test_live_is_offline(
    fresh: Dataset, detector: Detector, models: list[ModelWithInterval]
) -> None:
    done = [
        e
        for e in run(Pipeline(LAYOUT, detector, models), blocks_of(fresh))
        if isinstance(e, PinchDone)
    ]
    assert len(done) == len(fresh)
    for live, pinch in zip(done, fresh.pinches, strict=True):
        assert [e.duration for e in live.estimates] == [a.model.spec.duration for a in models]
        for estimate, entry in zip(live.estimates, models, strict=True):
            first, value = offline(detector, entry, pinch)
            assert (live.contacts[0], estimate.value) == (first, value)


@settings(max_examples=25)
@given(data=st.data())
def test_blocks_do_not_matter(
    fresh: Dataset, detector: Detector, models: list[ModelWithInterval], data: st.DataObject
) -> None:
    some = fresh.take([0, 1, 2])
    whole = told(run(Pipeline(LAYOUT, detector, models), blocks_of(some)))
    pieces = []
    for block in blocks_of(some):
        edges = data.draw(st.lists(st.integers(1, len(block.data) - 1), max_size=60))
        pieces += cut(block, edges)
    assert told(run(Pipeline(LAYOUT, detector, models), pieces)) == whole


@pytest.mark.parametrize("size", [1, 5, 14, 15, 16, 74, 494])
def test_block_sizes_do_not_matter(
    size: int, fresh: Dataset, detector: Detector, models: list[ModelWithInterval]
) -> None:
    some = fresh.take([3, 4])
    whole = told(run(Pipeline(LAYOUT, detector, models), blocks_of(some)))
    pieces = [p for b in blocks_of(some) for p in cut(b, list(range(size, len(b.data), size)))]
    assert told(run(Pipeline(LAYOUT, detector, models), pieces)) == whole


def test_samples_wait_for_what_is_due_and_for_nothing_else(
    fresh: Dataset, detector: Detector, models: list[ModelWithInterval]
) -> None:
    """Each thing is told with the frame that makes it known, though few frames are worked on."""
    pipeline = Pipeline(LAYOUT, detector, models)
    frames = [b for block in blocks_of(fresh) for b in cut(block, [*range(5, len(block.data), 5)])]
    known = 0
    for frame in frames:
        assert pipeline.due >= 1
        for event in pipeline.update(frame, 0.0):
            if isinstance(event, Touched | Estimated):
                at = event.contact.decided if isinstance(event, Touched) else event.complete
                assert frame.first_sample <= at < frame.end
                known += 1
    assert known > 2 * len(fresh)
    assert pipeline.ledger.blocks < len(frames) / 2


def test_truth_is_read_off_the_strips(fresh: Dataset, detector: Detector) -> None:
    done = [
        e for e in run(Pipeline(LAYOUT, detector), blocks_of(fresh)) if isinstance(e, PinchDone)
    ]
    for live, pinch in zip(done, fresh.pinches, strict=True):
        assert [(f, s) for f, s in live.strips] == [(c.finger, c.sample) for c in pinch.truth]


def test_an_estimate_says_whether_the_second_finger_was_there(
    fresh: Dataset, detector: Detector, models: list[ModelWithInterval]
) -> None:
    events = run(Pipeline(LAYOUT, detector, models), blocks_of(fresh))
    uses = set()
    for done in (e for e in events if isinstance(e, PinchDone)):
        for estimate in done.estimates:
            known = [c for c in done.contacts[1:] if c.decided <= estimate.complete]
            assert estimate.used is (not known)
            uses.add(estimate.used)
    assert uses == {True, False}  # the offsets of these pinches give both


def test_in_hindsight_the_computation_and_the_real_instant_count(
    fresh: Dataset, detector: Detector, models: list[ModelWithInterval]
) -> None:
    ticks = iter(range(10**9))
    slow = 1 / LAYOUT.rate  # each look at the clock takes a sample
    pipeline = Pipeline(LAYOUT, detector, models, clock=lambda: slow * next(ticks))
    cases = []
    for done in run(pipeline, blocks_of(fresh)):
        if isinstance(done, PinchDone):
            for estimate in done.estimates:
                case = done.case_of(estimate)
                assert estimate.waited > 0  # the whole pinch is one block
                out = estimate.contact.sample + estimate.after(LAYOUT.rate) * LAYOUT.rate
                late = len(done.contacts) > 1 and done.contacts[1].sample <= out
                assert case is (Case.TOO_LATE if late else Case.IN_TIME)
                # What was known to be too late stays so.
                assert estimate.used or case is Case.TOO_LATE
                cases.append((estimate.used, case))
    assert (True, Case.TOO_LATE) in cases


def test_a_window_across_a_gap_is_refused(
    fresh: Dataset, detector: Detector, models: list[ModelWithInterval]
) -> None:
    pinch = fresh.pinches[0]
    contact = offline(detector, models[-1], pinch)[0]
    at = contact.decided - pinch.first_sample + 2  # type: ignore[attr-defined]
    before = Block(pinch.data[:at], pinch.first_sample)
    after = Block(pinch.data[at + 3 :], pinch.first_sample + at + 3)
    events = run(Pipeline(LAYOUT, detector, models[-1:]), [before, after])
    assert not [e for e in events if isinstance(e, Estimated)]
    refused = [e for e in events if isinstance(e, Refused)]
    assert [r.reason for r in refused] == ["samples were lost"]
    done = [e for e in events if isinstance(e, PinchDone)]
    assert [d.refused for d in done] == ["samples were lost"]


def test_a_stream_that_ends_early_says_so(
    fresh: Dataset, detector: Detector, models: list[ModelWithInterval]
) -> None:
    pinch = fresh.pinches[0]
    contact = offline(detector, models[-1], pinch)[0]
    end = contact.decided - pinch.first_sample + 1  # type: ignore[attr-defined]
    pipeline = Pipeline(LAYOUT, detector, models[-1:])
    events = run(pipeline, [Block(pinch.data[:end], pinch.first_sample)])
    assert [type(e) for e in events if isinstance(e, Touched | Refused | PinchDone)] == [
        Touched,
        Refused,
        PinchDone,
    ]
    assert pipeline.finish() == []


@pytest.mark.parametrize("level", [0, 16_384, 32_736], ids=["low rail", "flat", "high rail"])
def test_a_dead_piezo_gives_no_estimate(
    level: int, fresh: Dataset, detector: Detector, models: list[ModelWithInterval]
) -> None:
    pinch = fresh.pinches[0]
    data = np.array(pinch.data)
    data[:, pinch.truth[0].finger] = level
    done = [
        e
        for e in run(Pipeline(LAYOUT, detector, models), [Block(data, 0)])
        if isinstance(e, PinchDone | Estimated)
    ]
    # What the other finger feels later is not this finger's contact.
    dead = Finger(pinch.truth[0].finger)
    for event in done:
        contacts = event.contacts if isinstance(event, PinchDone) else (event.contact,)
        assert dead not in [c.finger for c in contacts]


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_an_answer_that_is_no_number_is_refused(
    value: float,
    fresh: Dataset,
    detector: Detector,
    models: list[ModelWithInterval],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    model = models[-1].model
    monkeypatch.setattr(type(model), "predict_one", lambda self, window: value)
    events = run(Pipeline(LAYOUT, detector, models[-1:]), blocks_of(fresh))
    assert not [e for e in events if isinstance(e, Estimated)]
    refused = [e for e in events if isinstance(e, Refused)]
    assert {e.reason for e in refused} == {"the model's answer is no finite number"}
    assert len(refused) == len([e for e in events if isinstance(e, PinchDone)]) > 0


def test_motor_vibration_without_contact_says_nothing(
    fresh: Dataset, detector: Detector, models: list[ModelWithInterval]
) -> None:
    quiet = [
        Block(p.data[: p.truth[0].sample - p.first_sample], p.first_sample, i)
        for i, p in enumerate(fresh.pinches)
    ]
    events = run(Pipeline(LAYOUT, detector, models), quiet)
    assert not [e for e in events if isinstance(e, Touched | Estimated | PinchDone)]


def test_a_model_for_another_rate_is_refused(
    detector: Detector, models: list[ModelWithInterval]
) -> None:
    from dataclasses import replace

    with pytest.raises(InputError, match="4936"):
        Pipeline(replace(LAYOUT, rate=8000.0), ThresholdDetector(), models)


def test_the_ledger_adds_up(
    fresh: Dataset, detector: Detector, models: list[ModelWithInterval]
) -> None:
    ticks = iter(range(10**9))
    pipeline = Pipeline(LAYOUT, detector, models[-1:], clock=lambda: float(next(ticks)))
    events = run(pipeline, blocks_of(fresh))
    estimates = [e for e in events if isinstance(e, Estimated)]
    figures = pipeline.ledger.summary()
    assert figures["estimates"] == len(estimates) > 0
    assert figures["compute_max"] == max(e.host for e in estimates)
    rate = LAYOUT.rate
    waits = [(e.complete - e.contact.sample) / rate for e in estimates]
    assert figures["window_max"] == max(waits)
    # 74 samples and two of look-ahead after the contact's own.
    assert min(waits) == pytest.approx(75 / rate)


def test_a_stream_without_noise_floors_is_warned_of_once(
    detector: Detector, caplog: pytest.LogCaptureFixture
) -> None:
    """Each epoch is one closing then: of a stream all closings but the first are missed."""
    rng = np.random.default_rng(0)
    noise = rng.normal(0, 60, (8 * 4936, LAYOUT.width)).astype(np.int16)
    floors = Calibration(tuple(VibrationCalibration(f, 0.01) for f in Finger))
    stream = [Block(noise, 0), Block(noise, len(noise)), Block(noise, 2 * len(noise))]
    closings = [Block(noise, 0, epoch) for epoch in range(3)]
    for calibration, blocks, warnings in (
        (None, stream, 1),
        (None, closings, 0),
        (floors, stream, 0),
    ):
        caplog.clear()
        run(Pipeline(LAYOUT, detector, calibration=calibration), blocks)
        said = [r.getMessage() for r in caplog.records if r.levelname == "WARNING"]
        assert len(said) == warnings
        assert all("calibration" in text for text in said)
