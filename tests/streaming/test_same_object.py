"""Grouping of pinches by object, for pooled estimates."""

from __future__ import annotations

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
    predictions = [pinched.add_pinch(pinch(n)) for n in range(3)]
    expected = combine([30.0, 34.0, 32.0], [8.0, 4.0, 6.0])
    assert [t.pinches for t in predictions if t] == [1, 2, 3]
    last = predictions[-1]
    assert isinstance(last, ObjectEstimate)
    assert (last.value, last.low, last.high) == (expected.value, expected.low, expected.high)
    assert (last.number, last.level, last.end) == (2, ANSWER.level, 2900)


def test_answers_out_of_range_and_none_do_not_count() -> None:
    pinched = ObjectCombiner()
    pinched.new_object()
    pinched.add_pinch(pinch(0))
    assert pinched.add_pinch(pinch(1, out_of_range=True)) is None
    assert pinched.add_pinch(replace(pinch(2), estimates=())) is None
    again = pinched.add_pinch(pinch(3))
    assert again is not None
    assert (again.pinches, again.value) == (2, 30.0)


@pytest.mark.parametrize("how", ["asked", "marker", "label"])
def test_another_object_begins_where_somebody_says_so(how: str) -> None:
    pinched = ObjectCombiner()
    pinched.add_markers([Marker(5, "apple"), Marker(6, "twin: peak 3.0 N")])
    for n in (0, 1):
        pinched.add_pinch(pinch(n))
    if how == "asked":
        pinched.new_object()
    elif how == "marker":
        pinched.add_markers([Marker(2005, "pear")])
    estimate = pinched.add_pinch(pinch(2))
    if how == "label":  # of a replayed recording, which comes after its pinch
        assert pinched.add_labels([PinchMark(0, 2000, 2900, 0, Label("apple", 60.0))]) is None
        estimate = pinched.add_labels([PinchMark(0, 2000, 2900, 0, Label("pear", 60.0))])
    assert estimate is not None
    assert (estimate.pinches, estimate.value) == (1, 32.0)


@pytest.mark.parametrize("label_first", [True, False])
@pytest.mark.parametrize("has_markers", [True, False])
def test_labels_pool_before_and_after_their_pinch(label_first: bool, has_markers: bool) -> None:
    """In a simulated recording a label comes before its pinch is over, in others after it."""
    pinched = ObjectCombiner()
    predictions = []
    for n, name in enumerate(["apple", "apple", "apple", "pear", "pear", "apple"]):
        mark = PinchMark(n, 1000 * n, 1000 * n + 900, 0, Label(name, 60.0))
        if has_markers:
            pinched.add_markers([Marker(1000 * n, f"twin: {name}")])
        first = pinched.add_labels([mark]) if label_first else None
        assert first is None
        estimate = pinched.add_pinch(pinch(n))
        last = (None if label_first else pinched.add_labels([mark])) or estimate
        assert last is not None
        predictions.append(last.pinches)
    assert predictions == [1, 2, 3, 1, 2, 1]


def test_no_estimate_is_pooled_before_its_label() -> None:
    """A pinch of a block of 43 Shore A must not be pooled with those of one of 10."""
    pinched = ObjectCombiner()
    for n, name in enumerate(["block 10", "block 10", "block 43"]):
        early = pinched.add_pinch(pinch(n))
        assert (early is None) == (n > 0)
        mark = PinchMark(n, 1000 * n, 1000 * n + 900, 0, Label(name, 60.0))
        estimate = pinched.add_labels([mark])
    assert estimate is not None
    assert (estimate.pinches, estimate.value, estimate.number) == (1, 32.0, 2)


def test_where_nobody_says_what_is_pinched_each_pinch_stands_by_itself() -> None:
    """Two blocks of 29 and 50 Shore A must not be pooled to 40."""
    pinched = ObjectCombiner()
    for n in range(3):
        estimate = pinched.add_pinch(pinch(n))
        assert pinched.add_labels([PinchMark(n, 1000 * n, 1000 * n + 900, 0, Label())]) is None
        assert estimate is not None
        assert (estimate.pinches, estimate.value, estimate.is_named) == (1, ANSWERS[n].value, False)
    pinched.new_object()  # from here on somebody says it
    predictions = [pinched.add_pinch(pinch(n)) for n in (3, 4)]
    assert [(t.pinches, t.is_named) for t in predictions if t] == [(1, True), (2, True)]
