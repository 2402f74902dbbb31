"""Grouping of pinches by object, for pooled estimates."""

import pytest
from example_events import ANSWER, FIRST
from example_events import pinch as pinch_of
from msgspec.structs import replace

from firstcontact.core import Label
from firstcontact.models.predictions import combine
from firstcontact.recording import Marker, PinchMark
from firstcontact.streaming import ObjectEstimate, PinchDone
from firstcontact.streaming._objects import ObjectCombiner

ANSWERS = [replace(ANSWER, value=v, half_width=h) for v, h in ((30.0, 8.0), (34.0, 4.0), (32, 6))]


def pinch(n: int, **answer: object) -> PinchDone:
    rig_set = replace(ANSWERS[n % 3], **answer)  # type: ignore[arg-type]
    return pinch_of(rig_set, contacts=(FIRST,), number=n, start=1000 * n, end=1000 * n + 900)


def test_pinches_of_one_object_are_combined() -> None:
    pinched = ObjectCombiner()
    pinched.new_object()
    predictions = [pinched.pool(pinch(n)) for n in range(3)]
    expected = combine([30.0, 34.0, 32.0], [8.0, 4.0, 6.0])
    assert [t.pinches for t in predictions if t] == [1, 2, 3]
    last = predictions[-1]
    assert isinstance(last, ObjectEstimate)
    assert (last.value, last.low, last.high) == (expected.value, expected.low, expected.high)
    assert (last.number, last.level, last.end) == (2, ANSWER.level, 2900)


def test_answers_out_of_range_and_none_do_not_count() -> None:
    pinched = ObjectCombiner()
    pinched.new_object()
    pinched.pool(pinch(0))
    assert pinched.pool(pinch(1, out_of_range=True)) is None
    assert pinched.pool(replace(pinch(2), estimates=())) is None
    again = pinched.pool(pinch(3))
    assert (again.pinches, again.value) == (2, 30.0)


@pytest.mark.parametrize("how", ["asked", "marker"])
def test_another_object_begins_where_somebody_says_so(how: str) -> None:
    pinched = ObjectCombiner()
    pinched.add_markers([Marker(5, "apple"), Marker(6, "twin: peak 3.0 N")])
    assert [e and e.pinches for e in map(pinched.pool, map(pinch, (0, 1)))] == [1, 2]
    if how == "asked":
        pinched.new_object()
    else:
        pinched.add_markers([Marker(2005, "pear")])
    estimate = pinched.pool(pinch(2))
    assert (estimate.pinches, estimate.value) == (1, 32.0)
    assert pinched.name == {"asked": "", "marker": "pear"}[how]


@pytest.mark.parametrize("texts", [["sponge", "twin: apple"], ["twin: apple", "sponge"]])
def test_a_name_from_the_user_replaces_that_of_the_twin(texts: list[str]) -> None:
    pinched = ObjectCombiner()
    pinched.add_markers([Marker(5 + n, text) for n, text in enumerate(texts)])
    pinched.pool(pinch(0))
    assert pinched.name == "sponge"
    pinched.add_markers([Marker(1005, "twin: orange")])
    pinched.pool(pinch(1))
    assert pinched.name == "orange"


@pytest.mark.parametrize("has_markers", [True, False])
def test_labels_name_the_objects_of_a_replay(has_markers: bool) -> None:
    """A block of 43 Shore A must not be pooled with one of 10, whatever markers say."""
    pinched = ObjectCombiner()
    predictions = []
    for n, name in enumerate(["apple", "apple", "apple", "pear", "pear", "", "apple"]):
        if has_markers:
            pinched.add_markers([Marker(1000 * n, "twin: apple")])
        pinched.add_labels([PinchMark(n, 1000 * n, 1000 * n + 900, 0, Label(name, 60.0))])
        estimate = pinched.pool(pinch(n))
        predictions.append((estimate.pinches, estimate.is_named))
    named = [(n, True) for n in (1, 2, 3, 1, 2)]
    assert predictions == [*named, (1, False), (1, True)]


def test_where_nobody_says_what_is_pinched_each_pinch_stands_by_itself() -> None:
    """Two blocks of 29 and 50 Shore A must not be pooled to 40."""
    pinched = ObjectCombiner()
    for n in range(3):
        pinched.add_labels([PinchMark(n, 1000 * n, 1000 * n + 900, 0, Label())])
        estimate = pinched.pool(pinch(n))
        assert (estimate.pinches, estimate.value, estimate.is_named) == (1, ANSWERS[n].value, False)
    pinched.new_object()  # from here on somebody says it
    predictions = [pinched.pool(pinch(n)) for n in (3, 4)]
    assert [(t.pinches, t.is_named) for t in predictions if t] == [(1, True), (2, True)]
