"""Closings of the payload task: equal draws for all policies, and means of known rows."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from toys import OBJECTS, PEAKS, SESSIONS, row
from toys import rows as toy_rows

from firstcontact.core import Block, Contact, Estimate, Finger
from firstcontact.core.jobs import Serial, parallel
from firstcontact.core.layout import FINGERTIP_RATE
from firstcontact.grasp import Grip
from firstcontact.models import Model
from firstcontact.streaming import ClosingStart, ContactEvent, ContactWithdrawn, Event, NoEstimate
from firstcontact_lab.grasping._payload import (
    PinchSetup,
    Trial,
    TrialRow,
    Variant,
    by_policy,
    close,
    close_on,
    learn,
    run_trial,
    search,
    summary,
    trial_plant,
    unmodulated,
    variants,
)
from firstcontact_lab.grasping.settings import HEADLINE, KINDS, GraspStudySettings

SMALL = GraspStudySettings(
    sessions=2,
    latencies=(0.020,),
    training=10,
    windows=(0.003, 0.015),
    tuning=1,
    kinds=("block 5", "block 60"),
    workers=1,
)
TUNED = {"feedback": {"threshold": 0.05, "approach": 1.5, "speed": 0.02, "force": 2.6}}
BY_KEY = variants()
VARIANTS = tuple(BY_KEY.values())


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Model:
    return learn(SMALL, tmp_path_factory.mktemp("grasp"))


@pytest.fixture(scope="module")
def rows(model: Model) -> dict[str, TrialRow]:
    """Return the closings of all variants on the same pinch."""
    trial = Trial(PinchSetup("block 20", 0), VARIANTS, (0.020,), TUNED)
    return {row.variant: row for row in run_trial(trial, model)}


def test_every_policy_closes_on_the_same_pinch() -> None:
    data = []
    for variant in VARIANTS:
        # Force arrays differ between variants; what piezos and strips say does not.
        plant = trial_plant(PinchSetup("block 5", 3), variant, 0.04)
        block = plant.advance(900)
        data.append(np.concatenate([block[:, :2], block[:, 14:]], axis=1).tobytes())
        assert plant.limit == np.inf
    assert len(set(data)) == 1
    eggs = {
        trial_plant(PinchSetup("egg shell", 1), v, lat).limit
        for v in VARIANTS
        for lat in (0.0, 0.08)
    }
    assert len(eggs) == 1


def test_the_estimate_comes_and_the_hand_is_told_after_the_contact(model: Model) -> None:
    setup = PinchSetup("block 60", 1)
    plant = trial_plant(setup, BY_KEY["early_exit"], 0.020)
    predictions = close_on(plant, setup, BY_KEY["early_exit"], TUNED, model)
    first = plant.outcome.first_contact
    assert first is not None
    assert len(predictions.estimates) == len(SMALL.windows)
    approach, *remaining = predictions.orders
    assert approach.at < first
    assert remaining
    assert all(order.at > first for order in remaining)
    assert predictions.counts.contacts == 1
    assert predictions.counts.misses + predictions.counts.estimates >= 1


class _Script:
    """Stand-in for a pipeline, with events at given samples."""

    def __init__(self, events: Sequence[tuple[int, Event]]) -> None:
        self._events = list(events)

    def update(self, block: Block, host: float) -> Iterator[Event]:
        while self._events and self._events[0][0] < block.end:
            yield self._events.pop(0)[1]


def _after(sample: int, *moments: int) -> list[tuple[int, Event]]:
    """Return the events of a first contact and of its estimates, so many samples later."""
    contact = Contact(Finger.INDEX, sample - 2, sample)
    estimates = [
        (
            sample + m,
            Estimate(
                value=m, low=0, high=100, level=0.9, elapsed=m / FINGERTIP_RATE,
                available=m / FINGERTIP_RATE, model="script", contact=contact,
                complete=sample + m, epoch=0, host=0.0, compute=0.0,
            ),
        )
        for m in moments
    ]  # fmt: skip
    return [(sample, ContactEvent(contact, True, 0, 0.0)), *estimates]


@pytest.mark.parametrize("moments", [(), (10, 60)])
@pytest.mark.parametrize("refusal", [False, True])
def test_withdrawn_contacts_and_their_estimates_do_not_count(
    moments: tuple[int, ...], refusal: bool
) -> None:
    setup = PinchSetup("block 60", 1)
    variant = BY_KEY["early_exit" if moments else "touch"]
    plant = trial_plant(setup, variant, 0.020)
    grip = Grip(speed=plant.nominal.speed, force=plant.nominal.force)
    policy = variant.make(grip, KINDS[setup.kind].shore_a, {})
    false = Contact(Finger.INDEX, 298, 300)
    events: list[tuple[int, Event]] = [
        (250, ClosingStart(250, 0)),
        *_after(300, *moments[:1]),
        *([(311, NoEstimate(false, "too late", 311, 0))] if refusal else []),
        (314, ContactWithdrawn(false, 314, 0)),
        *_after(400, *moments),
    ]
    script: Any = _Script(events)
    record = close(plant, policy, script, len(moments), feels=False)
    assert record.counts.withdrawn == 1
    assert [e.value for e in record.estimates] == list(moments)
    assert sum(order.at > 400 / FINGERTIP_RATE for order in record.orders) > 0


def trials(variants: Sequence[Variant]) -> list[Trial]:
    return [Trial(PinchSetup(kind, 0), tuple(variants), (0.020,), TUNED) for kind in SMALL.kinds]


@pytest.mark.slow  # each worker imports for seconds
def test_same_seed_same_rows_on_one_worker_and_two(model: Model) -> None:
    alone = Serial().map(run_trial, trials(VARIANTS), model)
    with parallel(2) as runner:
        assert runner.map(run_trial, trials(VARIANTS), model) == alone


def test_the_search_finds_what_holds_and_asks_other_pinches_than_the_report() -> None:
    computed = search(SMALL, Serial())
    assert set(computed) == {"feedback", "feedback_fast"}
    for one in computed.values():
        assert one.tried == 4
        assert one.unsteady == 0
    reported, searched = (
        trial_plant(PinchSetup("block 5", 0, group), unmodulated(), 0.02).advance(400)
        for group in ("grasp", "search")
    )
    assert (reported != searched).any()


def test_the_time_is_of_steady_grasps_only() -> None:
    toy_rows = [row("block 5", s, "none", HEADLINE, 1.0) for s in range(4)]
    toy_rows[3] = replace(toy_rows[3], time=None)
    computed = summary(toy_rows, 0)
    assert computed.time_ms == pytest.approx(110.0)
    assert computed.steady == 0.75
    never = summary([replace(r, time=None) for r in toy_rows], 0)
    assert never.time_ms is None
    assert never.steady == 0.0


def test_the_trees_have_every_variant_and_latency() -> None:
    policies = by_policy(toy_rows(), 0)
    assert list(policies) == list(PEAKS)
    for variant, at in policies.items():
        assert list(at) == ["20", "60"]
        assert at["20"]["all"].n == SESSIONS * len(OBJECTS)
        assert at["20"]["soft"].n == SESSIONS * 2
        assert at["20"]["soft"].peak_n == pytest.approx(PEAKS[variant])
        assert at["60"]["brittle"].broken == (PEAKS[variant] > 6)
