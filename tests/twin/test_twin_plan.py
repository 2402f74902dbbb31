from __future__ import annotations

from collections import Counter

import pytest
from pinches import EVERYDAY, PAPER_RIG

from firstcontact.core import Role
from firstcontact.twin import (
    Condition,
)
from firstcontact.twin._simulate import plan_sessions


def test_the_paper_size_has_its_pinches_in_sessions() -> None:
    sessions = plan_sessions(PAPER_RIG, 500, 50, 0)
    labels = [p.label for s in sessions for p in s.pinches]
    assert Counter(x.role for x in labels) == {Role.TRAIN: 2500, Role.TEST: 400}
    assert set(Counter(x.object for x in labels if x.role is Role.TRAIN).values()) == {500}
    assert set(Counter(x.object for x in labels if x.role is Role.TEST).values()) == {50}
    objects = {x.object: x.shore_a for x in labels}
    assert sorted(objects.values()) == [10, 20, 26, 28, 29, 35, 37, 43, 45, 46, 59, 60, 67]
    for s in sessions:
        assert {p.label.session for p in s.pinches} == {s.name}
        assert len({p.label.object for p in s.pinches}) in (5, 8)
    assert len(sessions) == 12


def test_planned_pinches_are_unique() -> None:
    for condition in (PAPER_RIG, EVERYDAY):
        for s in plan_sessions(condition, 60, 10, 0):
            keys = [(p.label.specimen, p.number) for p in s.pinches]
            assert len(set(keys)) == len(keys)


def test_everyday_has_several_specimens_of_each_block_and_the_rig_one() -> None:
    def specimens(condition: Condition, size: int) -> int:
        planned = plan_sessions(condition, size, 0, 0)
        return len({p.label.specimen for s in planned for p in s.pinches})

    assert specimens(PAPER_RIG, 60) == 5
    assert specimens(EVERYDAY, 60) == 5 * EVERYDAY.specimens_per_block


def test_specimens_are_the_same_in_all_sessions() -> None:
    moduli: dict[str, set[float]] = {}
    for s in plan_sessions(EVERYDAY, 60, 4, 3):
        for p in s.pinches:
            moduli.setdefault(p.label.specimen, set()).add(p.specimen.nominal.modulus)
    assert {len(m) for m in moduli.values()} == {1}
    assert len({m for ms in moduli.values() for m in ms}) == len(moduli)


def test_objects_are_in_shuffled_order() -> None:
    (session, *_) = plan_sessions(PAPER_RIG, 100, 0, 0)
    order = [p.label.object for p in session.pinches]
    assert order != sorted(order)
    repeated = plan_sessions(PAPER_RIG, 100, 0, 0)[0]
    other_seed = plan_sessions(PAPER_RIG, 100, 0, 1)[0]
    assert [p.label.object for p in repeated.pinches] == order
    assert [p.label.object for p in other_seed.pinches] != order


@pytest.mark.parametrize(("blocks", "objects", "sessions"), [(2, 0, 2), (0, 1, 1), (3, 1, 4)])
def test_small_sets_have_as_many_sessions_as_pinches(
    blocks: int, objects: int, sessions: int
) -> None:
    planned = plan_sessions(PAPER_RIG, blocks, objects, 0)
    assert len(planned) == sessions
    assert sum(len(s.pinches) for s in planned) == 5 * blocks + 8 * objects
