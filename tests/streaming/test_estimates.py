"""Estimates of a closing: masked at the second contact, and the last one final."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from streams import cut, facts

from firstcontact.core import Block, Contact, Finger, InputError, Layout, fingertip_layout
from firstcontact.streaming import Estimate, Event, NoEstimate
from firstcontact.streaming._estimates import ClosingEstimates
from firstcontact.streaming._predictors import Prediction

LAYOUT = fingertip_layout()
RATE = LAYOUT.rate
FIRST = Contact(Finger.THUMB, 100, 110)


class Scripted:
    """Predictor for tests. Each estimate is the number of elapsed samples.

    At ``fails_at`` it raises an error instead.
    """

    name, rate, uses_shape, uses_speed = "scripted", RATE, False, False
    reason = ""

    def __init__(self, moments: Sequence[int], fails_at: int | None = None) -> None:
        self.samples = tuple(moments)
        self.moments = tuple(n / RATE for n in moments)
        self._left = list(moments)
        self._fails_at = fails_at
        self._contact: Contact | None = None

    def check(self, layout: Layout) -> None:
        assert layout is LAYOUT

    def start(self, layout: Layout, radius: float = np.nan, *, real_time: bool = False) -> Scripted:
        return Scripted(self.samples, self._fails_at)

    def warm(self) -> None:
        pass

    def prepare(self) -> None:
        pass

    due = None

    @property
    def ended(self) -> bool:
        return not self._left

    def update(self, block: Block, contact: Contact | None) -> Iterator[Prediction]:
        self._contact = self._contact or contact
        if self._contact is None:
            return
        ready = [n for n in self._left if self._contact.sample + n <= block.end]
        self._left = [n for n in self._left if n not in ready]
        for n in ready:
            if n == self._fails_at:
                raise InputError("the model failed")
            yield Prediction(
                value=float(n), low=n - 1.0, high=n + 1.0, level=0.9, elapsed=n / RATE,
                complete=self._contact.sample + n - 1,
            )  # fmt: skip


def closing(
    predictor: Scripted, second: Contact | None, edges: Sequence[int] = (), end: int = 300
) -> tuple[list[Event], ClosingEstimates]:
    """Return the events of a closing of samples 0 to 300, cut at these edges."""
    estimates = ClosingEstimates(predictor, LAYOUT, lambda: 0.0)
    events: list[tuple[int, Event]] = []
    for block in cut(Block(np.zeros((end, 1)), 0), sorted(set(edges))):
        labelled_contacts = [c for c in (FIRST, second) if c is not None and c.decided < block.end]
        events += estimates.update(block, labelled_contacts, 0.0, 0.0)
    finished = estimates.finish(end, 0, "the closing ended before the first estimate")
    return [event for _, event in sorted(events, key=lambda pair: pair[0])] + finished, estimates


def finals(events: list[Event]) -> list[float | str]:
    return [
        e.reason if isinstance(e, NoEstimate) else e.value
        for e in events
        if isinstance(e, NoEstimate) or (isinstance(e, Estimate) and e.final)
    ]


@given(
    moments=st.sets(st.integers(5, 80), min_size=1, max_size=6),
    offset=st.integers(-8, 120),
    delay=st.integers(1, 20),
    edges=st.lists(st.integers(1, 299), max_size=30),
)
def test_what_stands_depends_on_no_sample_after_the_second_contact(
    moments: set[int], offset: int, delay: int, edges: list[int]
) -> None:
    second = Contact(Finger.INDEX, 100 + offset, max(100 + offset, FIRST.decided) + delay)
    predictor = Scripted(sorted(moments))
    events, estimates = closing(predictor, second, edges)
    standing = [float(n) for n in sorted(moments) if n <= offset]
    assert [e.value for e in estimates.estimates] == standing
    assert [e.final for e in estimates.estimates] == [v == standing[-1] for v in standing]
    last = finals(events)[-1]
    assert last == (standing[-1] if standing else estimates.reason)
    assert bool(estimates.reason) is not bool(standing)
    assert facts(events) == facts(closing(predictor, second)[0])


def test_what_was_final_too_early_is_withdrawn() -> None:
    """The second contact is detected late, so a later event replaces the final estimate."""
    events, _ = closing(Scripted([20, 40]), Contact(Finger.INDEX, 130, 145))
    assert finals(events) == [40.0, 20.0]
    events, estimates = closing(Scripted([40]), Contact(Finger.INDEX, 130, 145))
    assert finals(events) == [40.0, estimates.reason]
    assert estimates.estimates == ()


@pytest.mark.parametrize(("fails_at", "expected"), [(20, [40.0]), (40, [20.0])])
def test_a_model_that_fails_at_one_moment_predicts_at_later_ones(
    fails_at: int, expected: list[float]
) -> None:
    events, _ = closing(Scripted([20, 40], fails_at), None, edges=range(5, 300, 5))
    assert finals(events) == expected


def test_a_model_that_always_fails_gives_its_reason() -> None:
    events, estimates = closing(Scripted([20], fails_at=20), None)
    assert finals(events) == ["the model failed"] == [estimates.reason]


def test_a_closing_that_ends_early_has_a_reason() -> None:
    events, _ = closing(Scripted([40]), None, end=120)
    assert finals(events) == ["the closing ended before the first estimate"]
