"""The network live: as offline at each millisecond, and silent after the second contact."""

from dataclasses import replace

import numpy as np
import pytest
from streams import as_blocks, cut_frames, run

from firstcontact.contact import Detector, detect
from firstcontact.core import ClosingSpeed, Contact, Dataset, Pinch, fingertip_layout
from firstcontact.models import Touches
from firstcontact.models.rig.rig_model import RigModel
from firstcontact.models.rig.rigs import RigSpeeds
from firstcontact.streaming import ContactEvent, Event, NoEstimate, PinchDone, Pipeline
from firstcontact.streaming.events import Estimate

LAYOUT = fingertip_layout()
RATE = LAYOUT.rate


def pipeline(detector: Detector, anytime: RigModel, **more: object) -> Pipeline:
    return Pipeline(LAYOUT, detector, anytime, **more)  # type: ignore[arg-type]


def count_samples(estimate: Estimate) -> int:
    return round(estimate.elapsed * RATE)


def made_after(contact: Contact, samples: int) -> list[int]:
    """Return the moments of the estimates from at most this many samples.

    When a contact is decided late, only the newest complete moment is estimated, one sample after
    the decision: the pitch of the motor comes first.
    """
    decided = contact.decided - contact.sample + 1
    decided += decided >= min(Touches.all_lengths(RATE))
    complete = [n for n in Touches.all_lengths(RATE) if n <= min(decided, samples)]
    return complete[-1:] + [n for n in Touches.all_lengths(RATE) if decided < n <= samples]


def touched(pinch: Pinch, first: Contact, second: Contact | None) -> Pinch:
    """Return the pinch with these contacts as its known ones."""
    return replace(pinch, truth=tuple(contact for contact in (first, second) if contact))


def test_live_is_offline(fresh: Dataset, detector: Detector, anytime: RigModel) -> None:
    events = run(pipeline(detector, anytime), cut_frames(fresh))
    pinches = [e for e in events if isinstance(e, PinchDone)]
    assert len(pinches) == len(fresh)
    for finished, pinch in zip(pinches, fresh.pinches, strict=True):
        first, second = (*detect(detector, pinch), None)[:2]
        touches, rows = Touches.cut(Dataset((touched(pinch, first, second),)), [first])
        assert list(rows) == [0]
        expected = made_after(first, int(touches.valid[0]))
        assert [count_samples(e) for e in finished.estimates] == expected
        assert [e.final for e in finished.estimates] == [n == expected[-1] for n in expected]
        for estimate in finished.estimates:
            offline = anytime.predict_touches(touches.until(count_samples(estimate)))
            assert estimate.value == pytest.approx(offline.value[0], abs=1e-3)
            assert estimate.low == pytest.approx(offline.low[0], abs=1e-3)
            assert estimate.high == pytest.approx(offline.high[0], abs=1e-3)
            assert estimate.out_of_range == offline.out_of_range[0]


def test_a_measured_speed_is_used_live_as_offline(
    fresh: Dataset, detector: Detector, anytime: RigModel
) -> None:
    knowing = anytime.conditioned_on(
        {finger: replace(rig, speeds=RigSpeeds(0.13, 0.3)) for finger, rig in anytime.rigs.items()}
    )
    speed = ClosingSpeed(0.2, 0.01)
    live = pipeline(detector, knowing)
    live.translator.measure_speed = lambda sample, epoch, host: speed
    finished = [e for e in run(live, cut_frames(fresh)) if isinstance(e, PinchDone)]
    unmeasured = [
        e for e in run(pipeline(detector, knowing), cut_frames(fresh)) if isinstance(e, PinchDone)
    ]
    for pinch, pinch_event, other in zip(fresh.pinches, finished, unmeasured, strict=True):
        assert pinch_event.closing_speed == speed
        assert other.closing_speed is None
        first, second = (*detect(detector, pinch), None)[:2]
        measured = replace(touched(pinch, first, second), closing_speed=speed)
        touches, _ = Touches.cut(Dataset((measured,)), [first])
        for estimate in pinch_event.estimates:
            offline = knowing.predict_touches(touches.until(count_samples(estimate)))
            assert estimate.value == pytest.approx(offline.value[0], abs=1e-3)
    assert any(
        abs(pinch_event.estimates[-1].value - other.estimates[-1].value) > 0.1
        for pinch_event, other in zip(finished, unmeasured, strict=True)
        if pinch_event.estimates
    )


def test_it_stops_at_the_second_contact(
    fresh: Dataset, detector: Detector, anytime: RigModel
) -> None:
    events = run(pipeline(detector, anytime), cut_frames(fresh))
    short = withdrawn = 0
    for finished_pinch in (e for e in events if isinstance(e, PinchDone)):
        epoch_events = [e for e in events if getattr(e, "epoch", None) == finished_pinch.epoch]
        running = [e for e in epoch_events if isinstance(e, Estimate) and not e.final]
        ends = [
            e
            for e in epoch_events
            if isinstance(e, NoEstimate) or (isinstance(e, Estimate) and e.final)
        ]
        assert len(ends) == 1
        if finished_pinch.final is None:
            assert isinstance(ends[0], NoEstimate)
        else:
            assert isinstance(ends[0], Estimate)
            assert ends[0].value == finished_pinch.final.value
        first, *remaining = finished_pinch.contacts
        if not remaining:
            continue
        offset = remaining[0].sample - first.sample
        assert all(count_samples(e) <= offset for e in finished_pinch.estimates)
        assert all(e.complete <= remaining[0].decided for e in running)
        withdrawn += len(running) - len(finished_pinch.estimates)
        short += offset < Touches.all_lengths(RATE)[-1]
    # Offsets of these pinches are such that the second contact cuts some short.
    assert short > 0
    assert withdrawn > 0


def test_a_shape_is_the_models_input_from_the_next_contact_on(
    fresh: Dataset, detector: Detector, anytime: RigModel
) -> None:
    live = pipeline(detector, anytime)
    first, second = as_blocks(fresh.take([0, 1]))
    events = list(live.update(first, 0.0))
    live.translator.radius = np.inf
    events += list(live.update(second, 0.0)) + live.finish()
    finished_pinch = [e for e in events if isinstance(e, PinchDone)]
    for entry, pinch, radius in zip(
        finished_pinch, fresh.pinches[:2], (np.nan, np.inf), strict=True
    ):
        assert entry.final.shape == ("" if np.isnan(radius) else "flat")
        touches, _ = Touches.cut(
            Dataset((touched(pinch, entry.contacts[0], None),)), entry.contacts[:1]
        )
        touches = replace(touches, radii=np.array([radius])).until(count_samples(entry.final))
        assert entry.final.value == pytest.approx(
            anytime.predict_touches(touches).value[0], abs=1e-3
        )


def test_a_speed_that_no_estimate_needs_is_asked_for_afterwards(
    fresh: Dataset, detector: Detector, anytime: RigModel
) -> None:
    speed, live = ClosingSpeed(0.2, 0.01), pipeline(detector, anytime)
    seen: list[int] = []
    events: list[Event] = []

    def measure(sample: int, epoch: int, host: float) -> ClosingSpeed:
        seen.append(sum(isinstance(e, ContactEvent) and e.first for e in events))
        return speed

    live.translator.measure_speed = measure
    for block in cut_frames(fresh):
        for event in live.update(block, 0.0):
            events.append(event)
    events += live.finish()
    finished = [e for e in events if isinstance(e, PinchDone)]
    assert [e.closing_speed for e in finished] == [speed] * len(finished)
    assert seen == list(range(1, len(finished) + 1))
