"""Live results: equal to offline results bit for bit, for any block size."""

from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from streams import as_blocks, cut, cut_frames, facts, offline, run

from firstcontact.contact import Detector
from firstcontact.core import (
    Block,
    Calibration,
    ChannelKind,
    Dataset,
    Finger,
    InputError,
    VibrationCalibration,
    fingertip_layout,
)
from firstcontact.models import Spec, Task, WindowPredictor
from firstcontact.models.anytime import PredictorLadder
from firstcontact.models.windows.svm import SvmModel, shape_and_level
from firstcontact.streaming import ContactEvent, Event, NoEstimate, PinchDone, Pipeline
from firstcontact.streaming.events import Estimate

LAYOUT = fingertip_layout()


def finished(events: list[Event]) -> list[PinchDone]:
    return [e for e in events if isinstance(e, PinchDone)]


def running(events: list[Event]) -> list[Estimate]:
    """Return the running estimates without the repeated final ones."""
    return [e for e in events if isinstance(e, Estimate) and not e.final]


def test_an_answer_that_is_not_finite_is_refused_aloud(fresh: Dataset, detector: Detector) -> None:
    """Weights can overflow for all windows but one. The closing then reports a reason."""
    tried = 0.1 * np.sin(np.arange(74.0))[None, :, None].astype(np.float32)
    one, target = np.array([0.0, 1.0]), np.array([0.0, 1e12])
    vector = shape_and_level(tried, one)
    spec, parameters = Spec(Task.REGRESSION, LAYOUT.rate, 74), np.ones(3)
    pipelines = [
        partial(Pipeline, LAYOUT, detector, WindowPredictor(
            SvmModel(spec, one, vector, weights, np.ones(1), target, parameters)
        ))
        for weights in (-np.ones((1, 1)), np.zeros((1, 1)))
    ]  # fmt: skip
    events = run(pipelines[0](), as_blocks(fresh.take([0])))
    assert not [e for e in events if isinstance(e, Estimate)]
    (refused,) = [e for e in events if isinstance(e, NoEstimate)]
    assert "not a finite number" in refused.reason
    with pytest.raises(InputError, match="not a finite number"):
        pipelines[1]()  # one that never answers is not begun with


def test_live_is_offline(fresh: Dataset, detector: Detector, models: list[WindowPredictor]) -> None:
    process = finished(run(Pipeline(LAYOUT, detector, PredictorLadder(models)), as_blocks(fresh)))
    assert len(process) == len(fresh)
    cut_short = 0
    for live, pinch in zip(process, fresh.pinches, strict=True):
        assert live.contacts[0] == offline(detector, models[0], pinch)[0]
        first, second = live.contacts[0].sample, live.second
        # The windows whose samples, with those that the filter looks ahead, lie before the second.
        ends = [first + e.model.spec.samples + 1 for e in models]
        standing = [
            e for e, end in zip(models, ends, strict=True) if not second or end < second.sample
        ]
        cut_short += len(standing) < len(models)
        assert [e.elapsed for e in live.estimates] == [e.model.spec.duration for e in standing]
        for estimate, entry in zip(live.estimates, standing, strict=True):
            assert estimate.value == np.float32(offline(detector, entry, pinch)[1])
    assert cut_short > 0


@settings(max_examples=25)
@given(data=st.data())
def test_blocks_do_not_matter(
    fresh: Dataset, detector: Detector, models: list[WindowPredictor], data: st.DataObject
) -> None:
    sample = fresh.take([0, 1, 2])
    facts_at_once = facts(
        run(Pipeline(LAYOUT, detector, PredictorLadder(models)), as_blocks(sample))
    )
    pieces = []
    for block in as_blocks(sample):
        edges = data.draw(st.lists(st.integers(1, len(block.data) - 1), max_size=60))
        pieces += cut(block, edges)
    assert facts(run(Pipeline(LAYOUT, detector, PredictorLadder(models)), pieces)) == facts_at_once


def test_samples_wait_for_what_is_due_and_for_nothing_else(
    fresh: Dataset, detector: Detector, models: list[WindowPredictor]
) -> None:
    """Each event arrives with the frame that decides it, although only few frames are processed."""
    pipeline = Pipeline(LAYOUT, detector, PredictorLadder(models))
    frames = cut_frames(fresh)
    labelled_contacts = 0
    for frame in frames:
        assert pipeline.due >= 1
        for event in pipeline.update(frame, 0.0):
            if isinstance(event, ContactEvent) or (isinstance(event, Estimate) and not event.final):
                assert frame.first_sample <= event.known_sample < frame.end
                labelled_contacts += 1
    assert labelled_contacts > 2 * len(fresh)
    assert pipeline.ledger.blocks < len(frames) / 2


def test_a_window_across_a_gap_is_refused(
    fresh: Dataset, detector: Detector, models: list[WindowPredictor]
) -> None:
    pinch = fresh.pinches[0]
    contact = offline(detector, models[-1], pinch)[0]
    at = contact.decided - pinch.first_sample + 2  # type: ignore[attr-defined]
    head = Block(pinch.data[:at], pinch.first_sample)
    tail = Block(pinch.data[at + 3 :], pinch.first_sample + at + 3)
    events = run(Pipeline(LAYOUT, detector, PredictorLadder(models[-1:])), [head, tail])
    assert not running(events)
    refused = [e for e in events if isinstance(e, NoEstimate)]
    assert [r.reason for r in refused] == ["samples were lost"]
    assert [d.reason for d in finished(events)] == ["samples were lost"]


@pytest.mark.parametrize("level", [0, 16_384, 32_736], ids=["low rail", "flat", "high rail"])
def test_a_dead_piezo_gives_no_estimate(
    level: int, fresh: Dataset, detector: Detector, models: list[WindowPredictor]
) -> None:
    pinch = fresh.pinches[0]
    data = np.array(pinch.data)
    data[:, pinch.truth[0].finger] = level
    live = Pipeline(LAYOUT, detector, PredictorLadder(models))
    process = [e for e in run(live, [Block(data, 0)]) if isinstance(e, PinchDone | Estimate)]
    # What the other finger feels later is not this finger's contact.
    dead = Finger(pinch.truth[0].finger)
    for event in process:
        contacts = event.contacts if isinstance(event, PinchDone) else (event.contact,)
        assert dead not in [c.finger for c in contacts]


def test_a_stream_without_noise_floors_is_warned_of_once(
    detector: Detector, caplog: pytest.LogCaptureFixture
) -> None:
    """Without noise floors each epoch counts as one closing, so later closings are missed."""
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
        log = [r.getMessage() for r in caplog.records if r.levelname == "WARNING"]
        assert len(log) == warnings
        assert all("calibration" in text for text in log)


def test_a_load_that_hides_all_closings_is_warned_of_once(
    detector: Detector, caplog: pytest.LogCaptureFixture
) -> None:
    second = round(LAYOUT.rate)
    volts = np.random.default_rng(0).normal(0, 0.01, (20 * second, LAYOUT.width))
    volts[np.arange(len(volts)) % second > second // 2, :2] *= 3.0
    volts[:, 2:] = 0.0
    floors = Calibration(tuple(VibrationCalibration(f, 0.01) for f in Finger))
    scale, offset = (
        np.array([getattr(c, name) for c in LAYOUT.column_channels]) for name in ("scale", "offset")
    )
    for load, warnings in ((0.0, 0), (0.35, 1)):
        caplog.clear()
        volts[second:, LAYOUT.columns(ChannelKind.FORCE)] = load
        blocks = cut(Block(volts / scale + offset), [*range(second, len(volts), second)])
        run(Pipeline(LAYOUT, detector, calibration=floors), blocks)
        log = [r.getMessage() for r in caplog.records if r.levelname == "WARNING"]
        assert len(log) == warnings
        assert all("force" in text for text in log)
