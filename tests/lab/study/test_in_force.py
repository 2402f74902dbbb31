"""Estimates in force, and the force of the first finger before the second contact."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from excerpts import subject, twin_pinches

from firstcontact.core import ChannelKind, Dataset, InputError, Pinch, Role
from firstcontact.jobs import Serial
from firstcontact.models import Touches
from firstcontact.twin import BLOCKS
from firstcontact.twin.objects import EVERYDAY_OBJECTS
from firstcontact_lab.study.part import StudySettings, Subject
from firstcontact_lab.study.parts.anytime import anytime
from firstcontact_lab.study.parts.data import EARLY_FORCE, describe, early_force
from firstcontact_lab.study.parts.in_force import (
    IN_FORCE,
    InForce,
    LiveDelays,
    in_force,
    last_samples,
    read_delays,
)

BRIEF = StudySettings().quick()
RATE = 4936.0


@pytest.fixture(scope="module")
def conditioned() -> Subject:
    pinches = twin_pinches(BLOCKS, 6, 3) + twin_pinches(EVERYDAY_OBJECTS[:3], 4, 2)
    made = subject(pinches)
    assert anytime(made, BRIEF, Serial()).results
    return made


def scores(made: Subject, folder: Path, delay_ms: float) -> InForce | None:
    path = folder / "live.json"
    tree = {"machine": "a computer", "first_ms": [delay_ms], "later_ms": [delay_ms]}
    path.write_text(json.dumps(tree))
    return in_force(made, replace(BRIEF, delays=str(path))).results[IN_FORCE]


@pytest.mark.parametrize("delay_ms", [0.0, 1.0, 6.5])
def test_scores_are_those_of_the_last_estimate_of_each_pinch(
    conditioned: Subject, tmp_path: Path, delay_ms: float
) -> None:
    """Each pinch is predicted by itself, once, at the last moment that is in time."""
    result = scores(conditioned, tmp_path, delay_ms)
    assert result is not None
    assert conditioned.adapted is not None
    answered, errors, lengths = [], [], []
    for pinch, contact in zip(conditioned.dataset, conditioned.detections, strict=True):
        if pinch.second is None or contact is None:
            continue
        arrivals = [max(contact.sample + n - 1, contact.decided) for n in Touches.all_lengths(RATE)]
        latest = pinch.second.sample - 1e-3 * delay_ms * RATE
        n = max(
            (n for n, at in zip(Touches.all_lengths(RATE), arrivals, strict=True) if at < latest),
            default=0,
        )
        answered.append(n > 0)
        if n and pinch.label.role is Role.TEST:
            touches, _ = Touches.cut(Dataset((pinch,)), [contact])
            value = conditioned.adapted.model.predict_touches(touches.until(n)).value[0]
            errors.append(value - (pinch.label.shore_a or 0.0))
            lengths.append(n / RATE)
    assert (result.share, result.with_second) == (np.mean(answered), len(answered))
    assert result.n == len(errors)
    assert result.rmse == pytest.approx(np.sqrt(np.mean(np.square(errors))))
    assert result.signal_ms == pytest.approx(1e3 * np.median(lengths))


def test_an_early_contact_counts_and_a_missed_one_has_no_estimate(conditioned: Subject) -> None:
    delays = LiveDelays("a computer", (1.0,), (1.0,))
    samples = last_samples(conditioned, delays, 0)
    first = next(i for i, n in enumerate(samples) if 0 < n < Touches.all_lengths(RATE)[-1])
    contacts = list(conditioned.detections)
    contact = contacts[first]
    contacts[first] = replace(contact, sample=contact.sample - 200, decided=contact.decided - 200)
    early = last_samples(replace(conditioned, detections=tuple(contacts)), delays, 0)
    assert early[first] == Touches.all_lengths(RATE)[-1]
    contacts[first] = None
    missed = last_samples(replace(conditioned, detections=tuple(contacts)), delays, 0)
    assert missed[first] == 0
    assert np.array_equal(np.delete(missed, first), np.delete(samples, first))


def test_without_delays_or_a_model_nothing_is_scored(conditioned: Subject, tmp_path: Path) -> None:
    outcome = in_force(conditioned, BRIEF)
    assert outcome.results[IN_FORCE] is None
    assert not outcome.left_out
    assert in_force(conditioned, replace(BRIEF, parts=("in_force",))).left_out
    assert scores(Subject("any", conditioned.dataset), tmp_path, 1.0) is None


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[1, 2]",
        '{"machine": "m", "first_ms": [1], "later_ms": []}',
        '{"machine": "m", "first_ms": [2, 1], "later_ms": [1]}',
    ],
)
def test_other_files_are_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "live.json"
    path.write_text(text)
    with pytest.raises(InputError, match=r"live\.json"):
        read_delays(path)


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
