"""Error that pinches of one object share, compared with the package's constant."""

from __future__ import annotations

import numpy as np
import pytest

from firstcontact.models import pretrained_folder, read_card
from firstcontact.models._predictions import SHARED
from firstcontact_lab.pretraining._examples import ASKED, THINGS, rig_examples
from firstcontact_lab.pretraining._same_object import PINCHES, coverage, shared_part


@pytest.mark.parametrize("part", [0.0, 0.5, 0.9, 1.0])
def test_the_shared_part_of_errors_is_recovered(part: float) -> None:
    rng = np.random.default_rng(0)
    n = 20_000
    truth, half = np.full(n, 40.0), rng.uniform(5, 20, (n, PINCHES))
    error = part * rng.standard_normal((n, 1)) + np.sqrt(1 - part**2) * rng.standard_normal(
        (n, PINCHES)
    )
    values = truth[:, None] + half / 1.6449 * error
    assert shared_part(values, half, truth) == pytest.approx(part, abs=0.09 if part < 0.1 else 0.02)
    if part == 0.9:
        # Of Gaussian errors with about the share that is taken, as many are held as of one.
        assert coverage(values, half, truth, 1) == pytest.approx(0.9, abs=0.01)
        assert coverage(values, half, truth, PINCHES) == pytest.approx(0.9, abs=0.02)


def test_the_share_that_is_taken_is_the_one_that_was_measured() -> None:
    results = read_card(pretrained_folder()).predictors[0].record.scores["same object"]["ms"]
    assert round(max(entry["shared"] for entry in results.values()), 2) == SHARED
    assert all(
        0.88 <= is_covered <= 0.92
        for entry in results.values()
        for is_covered in entry["coverage"].values()
    )


def test_each_thing_is_pinched_again_in_one_session() -> None:
    once, again = rig_examples(1, 5), rig_examples(1, 5, again=PINCHES)
    assert (once.object_ids >= 0).sum() == THINGS * ASKED
    assert (again.object_ids >= 0).sum() == THINGS * PINCHES
    objects = again.object_ids[: THINGS * PINCHES].reshape(THINGS, PINCHES)
    assert (objects == np.arange(THINGS)[:, None]).all()
