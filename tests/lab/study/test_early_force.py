"""The force of the first finger before the second contact."""

from dataclasses import replace

import pytest
from excerpts import twin_pinches

from firstcontact.core import ChannelKind, Dataset, Pinch
from firstcontact.twin.objects import EVERYDAY_OBJECTS
from firstcontact_lab.study.part import Subject
from firstcontact_lab.study.parts.data import EARLY_FORCE, describe, early_force


@pytest.fixture(scope="module")
def pinch() -> Pinch:
    return next(p for p in twin_pinches(EVERYDAY_OBJECTS[:1], 4, 1) if p.second is not None)


def stepped(pinch: Pinch, before: float, after: float) -> Pinch:
    """Return the pinch with a constant force before and after the second contact."""
    first, second = (contact.sample - pinch.first_sample for contact in pinch.truth[:2])
    data = pinch.data.copy()
    for finger in {contact.finger for contact in pinch.truth}:
        columns = list(pinch.layout.columns(ChannelKind.FORCE, finger))
        data[:first, columns], data[first:second, columns] = 0, before
        data[second:, columns] = after
    return replace(pinch, data=data)


def test_the_force_is_a_share_of_the_later_force(pinch: Pinch) -> None:
    for before in (0, 100, 250):
        assert early_force(stepped(pinch, before, 1000)) == pytest.approx(before / 1000)
    assert early_force(stepped(pinch, 0, 0)) is None
    assert early_force(replace(pinch, truth=pinch.truth[:1])) is None


def test_the_data_have_the_median_over_pinches(pinch: Pinch) -> None:
    pinches = tuple(stepped(pinch, before, 1000) for before in (0, 100, 900))
    force = describe(Subject("any", Dataset(pinches))).results[EARLY_FORCE]
    assert (force.n, force.median) == (3, pytest.approx(0.1))
    assert force.median <= force.p95 <= 0.9
