"""Live withdrawal of false contacts: estimates, events and the hand."""

import io
import json
from dataclasses import replace

import numpy as np
import pytest
from example_events import DESCRIPTOR, FIRST, FIRST_EVENT, SECOND_EVENT

from firstcontact.contact import ThresholdDetector, detect
from firstcontact.core import Block, Contact, Dataset, Finger, Pinch, fingertip_layout
from firstcontact.device import Arrival
from firstcontact.grasp import Grip
from firstcontact.grasp.printing import PrintHand
from firstcontact.grasp.registry import live_policy
from firstcontact.models import WindowPredictor
from firstcontact.models.anytime import Predictor, PredictorLadder
from firstcontact.models.rig.rig_model import RigModel
from firstcontact.streaming import (
    ContactEvent,
    ContactWithdrawn,
    Event,
    PinchDone,
    Pipeline,
    Update,
)
from firstcontact.streaming.events import Estimate
from firstcontact.streaming.grasping import Grasping
from firstcontact.streaming.page.state import State

LAYOUT = fingertip_layout()
CLICK = 400


@pytest.fixture(scope="module", params=[(0,), (0, 1)], ids=["one finger", "both fingers"])
def clicked(request: pytest.FixtureRequest, fresh: Dataset) -> Pinch:
    """Return a pinch in which a gear clicks 50 ms or more before the contact."""
    pinch = fresh.pinches[4]
    assert pinch.first.sample - pinch.first_sample > CLICK + 100
    data = pinch.data.copy()
    data[CLICK : CLICK + 4, list(request.param)] += 32 * np.array([[30], [-22], [12], [-6]], "i2")
    return replace(pinch, data=data)


def predictors(models: list[WindowPredictor], anytime: RigModel) -> list[Predictor]:
    return [PredictorLadder(models), anytime]


def live(pinch: Pinch, predictor: Predictor, size: int) -> list[Event]:
    pipeline = Pipeline(LAYOUT, ThresholdDetector(8.0), predictor, clock=lambda: 0.0)
    events: list[Event] = []
    for i in range(0, len(pinch.data), size):
        block = Block(pinch.data[i : i + size], pinch.first_sample + i)
        events += pipeline.update(block, 0.0)
    return events + pipeline.finish()


@pytest.mark.parametrize("index", [0, 1])
def test_true_contact_gets_the_estimates_that_it_gets_offline(
    index: int, clicked: Pinch, models: list[WindowPredictor], anytime: RigModel
) -> None:
    rows_by_size = {}
    contacts = detect(ThresholdDetector(8.0), clicked)
    for size in (1, 7, 60, len(clicked.data)):
        events = live(clicked, predictors(models, anytime)[index], size)
        (pinch_done,) = (e for e in events if isinstance(e, PinchDone))
        withdrawn = [e for e in events if isinstance(e, ContactWithdrawn)]
        firsts = [e.contact for e in events if isinstance(e, ContactEvent) and e.first]
        assert pinch_done.contacts == tuple(contacts)
        assert firsts == [*(w.contact for w in withdrawn), contacts[0]]
        assert len(withdrawn) == 1
        place = events.index(withdrawn[0])
        later = [e for e in events[place:] if isinstance(e, Estimate)]
        assert all(e.contact == contacts[0] for e in (*later, *pinch_done.estimates))
        assert pinch_done.estimates
        rows_by_size[size] = [(e.value, e.low, e.high, e.elapsed) for e in pinch_done.estimates]
    alone = [e for e in live(_without_click(clicked), predictors(models, anytime)[index], 60)
             if isinstance(e, PinchDone)]  # fmt: skip
    assert len({tuple(rows) for rows in rows_by_size.values()}) <= 2  # all at once, or one by one
    assert len(alone[0].estimates) == len(rows_by_size[60])


def _without_click(pinch: Pinch) -> Pinch:
    data = pinch.data.copy()
    data[CLICK - 20 : CLICK + 60, :2] = data[CLICK - 100 : CLICK - 20, :2]
    return replace(pinch, data=data)


@pytest.mark.parametrize("name", ["first_contact", "stiffness", "early_exit"])
def test_hand_closes_on_as_before_the_withdrawn_contact(
    name: str, clicked: Pinch, models: list[WindowPredictor]
) -> None:
    with PrintHand(out=io.StringIO()) as hand:
        grasping = Grasping(live_policy(name, Grip()), hand, LAYOUT)
        at_withdrawal = []
        for event in live(clicked, PredictorLadder(models), 5):
            command = grasping.last
            grasping.on_event(event)
            if isinstance(event, ContactWithdrawn):
                at_withdrawal.append((command, grasping.loop.counts.contacts))
    counts = grasping.loop.counts
    assert len(at_withdrawal) == counts.withdrawn == 1
    assert at_withdrawal[0][1] == 0
    assert (counts.closings, counts.contacts) == (1, 1)


def test_page_drops_marks_and_closeup_of_a_withdrawn_contact_only() -> None:
    state = State(DESCRIPTOR, {}, None)
    seen: dict[str, int] = {}
    samples = Arrival(Block(np.zeros((700, len(LAYOUT.channels)), "i2"), 0), 0.0)
    earlier = ContactEvent(Contact(Finger.INDEX, 200, 212), True, 0, 1000.0)
    state.take(Update((samples,), (earlier,)))
    marks = json.loads(state.changed(seen)["marks"])
    early = ContactEvent(Contact(Finger.INDEX, 505, 524), False, 0, 1000.12)
    for seconds in ((), (SECOND_EVENT,), (early,)):
        state.take(Update((), (FIRST_EVENT, *seconds)))
        parts = state.changed(seen)
        assert len(json.loads(parts["marks"])) == 2 + len(seconds)
        assert json.loads(parts["closeup"])["marks"]
        state.take(Update((), (ContactWithdrawn(FIRST, 525, 0),)))
        parts = state.changed(seen)
        assert json.loads(parts["marks"]) == marks
        assert json.loads(parts["closeup"]) is None
    state.take(Update((), (FIRST_EVENT,)))
    parts = state.changed(seen)
    assert len(json.loads(parts["marks"])) == 2
    assert len(json.loads(parts["closeup"])["marks"]) == 1
