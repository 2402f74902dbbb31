"""A window ladder predicts at several times and never uses later samples."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from firstcontact.core import InputError
from firstcontact_lab.study.window_ladder import LEVEL, LadderModel, fit_window_ladder
from ringing import LONGEST, SHORTEST, ringing

TOUCHES, SHORE_A, SESSIONS = ringing(120)


def fitted() -> LadderModel:
    return fit_window_ladder("peak", TOUCHES, SHORE_A, SESSIONS)


def test_samples_after_the_valid_ones_do_not_matter() -> None:
    rng = np.random.default_rng(3)
    ends = rng.integers(SHORTEST, LONGEST + 1, len(TOUCHES))
    short = replace(TOUCHES, valid=ends)
    spoilt = short.signals.copy()
    for row, end in enumerate(ends):
        spoilt[row, short.lead + end :] = np.nan
    models = [
        fit_window_ladder("svm", given, SHORE_A, SESSIONS)
        for given in (short, replace(short, signals=spoilt))
    ]
    first, second = (m.predict_touches(replace(short, signals=spoilt)) for m in models)
    assert np.isfinite(first.value).all()
    assert np.array_equal(first.value, second.value)


def test_a_contact_is_answered_for_by_the_longest_window_that_it_fills() -> None:
    model = fitted()
    for samples, shorter in ((24, 15), (25, 25), (73, 39)):
        sample = model.predict_touches(TOUCHES.until(samples))
        assert np.array_equal(sample.value, model.predict_touches(TOUCHES.until(shorter)).value)


def test_what_is_too_short_or_constant_is_strange_with_the_whole_scale() -> None:
    dead = replace(TOUCHES, signals=np.zeros_like(TOUCHES.signals))
    for queries in (TOUCHES.until(SHORTEST - 1), dead):
        answers = fitted().predict_touches(queries)
        assert answers.out_of_range.all()
        assert (answers.low == 0).all()
        assert (answers.high == 100).all()
        assert np.isfinite(answers.value).all()


def test_intervals_hold_what_was_promised_of_alike_contacts() -> None:
    remaining, truth, _ = ringing(400, seed=9)
    answers = fitted().predict_touches(remaining)
    share = np.mean((answers.low <= truth) & (truth <= answers.high))
    # 120 calibrate, 400 are predicted: three standard deviations of both.
    assert abs(share - LEVEL) < 3 * np.sqrt(LEVEL * (1 - LEVEL) * (1 / 120 + 1 / 400)) + 0.03


def test_with_few_contacts_there_is_an_answer_and_no_interval() -> None:
    few = np.arange(20)
    model = fit_window_ladder("peak", TOUCHES.take(few), SHORE_A[few])
    answers = model.predict_touches(TOUCHES)
    assert (answers.high - answers.low == 100).all()
    with pytest.raises(InputError, match="too few"):
        fit_window_ladder("peak", TOUCHES.take(few[:5]), SHORE_A[few[:5]])


def test_a_class_of_anybody_gets_copies_of_two_dimensions() -> None:
    seen: list[tuple[int, ...]] = []

    class Mine:
        def fit(self, X: Any, y: Any) -> None:  # returns nothing, and writes where it reads
            seen.append(X.shape)
            self.mean = float(y.mean())
            X[:], y[:] = 0.0, 0.0

        def predict(self, X: Any) -> Any:
            return np.full((len(X), 1), self.mean)

    head, truth = TOUCHES.signals.copy(), SHORE_A.copy()
    answers = fit_window_ladder(Mine, TOUCHES, SHORE_A, SESSIONS).predict_touches(TOUCHES)
    assert np.allclose(answers.value, SHORE_A.mean())
    assert np.array_equal(TOUCHES.signals, head)
    assert np.array_equal(SHORE_A, truth)
    assert {s[1] for s in seen} == {10, 15, 25, 39, 74}


@pytest.mark.parametrize("answer", [np.nan, np.inf])
def test_answers_that_are_no_numbers_are_refused(answer: float) -> None:
    class Bad:
        def fit(self, X: Any, y: Any) -> None: ...

        def predict(self, X: Any) -> Any:
            return np.full(len(X), answer)

    with pytest.raises(InputError):
        fit_window_ladder(Bad, TOUCHES, SHORE_A)
