"""Study of recordings with a stiffness: errors over time, sessions and levels held out."""

from dataclasses import replace

import numpy as np
import pytest

from firstcontact.core import Dataset
from firstcontact.jobs import Serial
from firstcontact_lab.report.results import NOTHING
from firstcontact_lab.study.part import StudySettings, Subject
from firstcontact_lab.study.parts.stiffness import STIFFNESS, TABLES, stiffness
from firstcontact_lab.study.sets import stiffness_curves
from toy_pinches import shore_dataset

BRIEF = StudySettings(brief=True)


def springs(sessions: int = 3) -> Dataset:
    """Return toy pinches whose objects have 2 N/mm at 10 Shore A, and twice that each 20 more."""
    data = shore_dataset(each=24, sessions=sessions)
    labels = [
        replace(p.label, shore_a=None, stiffness_n_per_mm=2 ** (1 + (p.label.shore_a - 10) / 20))
        for p in data
    ]
    pinches = (replace(p, label=n) for p, n in zip(data, labels, strict=True))
    return replace(data, pinches=tuple(pinches))


def test_errors_are_factors_with_sessions_and_inner_levels_held_out():
    outcome = stiffness(Subject("springs", springs()), BRIEF, Serial())
    found = outcome.results[STIFFNESS]
    assert (found.quantity, found.sessions, found.pinches) == ("stiffness_n_per_mm", 3, 72)
    assert found.placed.found == found.placed.placed == 96
    last = found.by_time["15"]
    levels = np.log([2, 4, 2 * 2**2.5])
    assert last["train_mean"].errors.rmse == pytest.approx(levels.std(), rel=0.05)
    assert last["svm"].errors.rmse < 0.5 * last["train_mean"].errors.rmse
    assert found.relative_error("15", "svm") < 0.5
    assert 0.6 < last["svm"].coverage <= 1
    assert list(found.levels_left_out) == ["4"]
    assert set(found.levels_left_out["4"]) == {"svm", "log_spectrum"}
    tables = [make(outcome.results) for make in TABLES]
    assert all(table.lines for table in tables)
    assert [figure.key for figure in outcome.figures] == ["stiffness"]
    assert stiffness_curves({"springs": outcome.results, "twin": outcome.results}) is not None
    assert stiffness_curves({"twin": outcome.results, "others": NOTHING}) is None


def test_one_session_is_left_out_with_its_reason():
    outcome = stiffness(Subject("springs", springs(sessions=1)), BRIEF, Serial())
    assert outcome.results[STIFFNESS] is None
    assert any("sessions" in reason for reason in outcome.left_out)


@pytest.mark.parametrize("data", [shore_dataset(each=3)], ids=["Shore A"])
def test_other_labels_have_no_such_part(data):
    outcome = stiffness(Subject("blocks", data), BRIEF, Serial())
    assert outcome.results is NOTHING
    assert not outcome.left_out
