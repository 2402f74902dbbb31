"""Sets of single contacts: two hands, the same things, contacts placed about where they are."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from firstcontact.core import InputError
from firstcontact.learning.rig_sets import OTHER_HAND, RigSet, rig_set
from firstcontact.twin.objects import BLOCKS, EVERYDAY_OBJECTS


@cache
def small() -> RigSet:
    return rig_set("everyday", 4, blocks=8, objects=2)


def test_every_thing_is_touched_as_often_as_asked() -> None:
    made = small()
    assert len(made.blocks) == 8 * len(BLOCKS)
    assert len(made.objects) == len(made.other_objects) == 2 * len(EVERYDAY_OBJECTS)
    assert len(made.other_blocks) == OTHER_HAND * len(BLOCKS) == 30
    assert set(made.blocks.shore_a) == {kind.shore_a for kind in BLOCKS}
    assert set(made.objects.shore_a) == {kind.shore_a for kind in EVERYDAY_OBJECTS}
    assert not set(made.blocks.sessions) & set(made.objects.sessions)
    assert len(set(made.blocks.sessions)) > 2


def test_a_contact_is_quiet_before_and_loud_after() -> None:
    touches = small().blocks.touches
    whole = touches.valid == touches.after.shape[1]
    assert whole.any()
    assert not whole.all()  # some second contacts come early
    before = np.abs(touches.signals[whole, : touches.before - 20]).max(axis=1)
    after = np.abs(touches.after[whole]).max(axis=1)
    assert np.mean(after > 2 * before) > 0.9


def test_the_second_hand_differs_and_touches_the_same_specimens() -> None:
    made = small()
    assert set(made.other_objects.specimens) == set(made.objects.specimens)
    own = np.abs(made.objects.touches.after).max()
    assert not np.isclose(own, np.abs(made.other_objects.touches.after).max())


def test_the_same_seed_gives_the_same_set_and_another_another() -> None:
    sets = [rig_set("paper-rig", seed, blocks=1, objects=1) for seed in (1, 1, 2)]
    first, again, other = (s.blocks.touches.signals for s in sets)
    assert np.array_equal(first, again)
    assert not np.array_equal(first[: len(other)], other[: len(first)])


def test_a_condition_that_is_not_there() -> None:
    with pytest.raises(InputError, match="tropical"):
        rig_set("tropical", 1)
