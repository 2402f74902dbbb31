"""Onset picker: it finds the end of the quiet part."""

from __future__ import annotations

import numpy as np

from firstcontact.contact._finder import pick_onset


def test_onset_is_the_change_of_variance():
    rng = np.random.default_rng(0)
    errors = []
    for onset in rng.integers(75, 95, 200):
        x = rng.normal(size=(1, 99))
        x[0, onset:] *= 30
        errors.append(int(pick_onset(x, 30)[0]) - onset)
    assert np.median(np.abs(errors)) <= 1
    assert np.percentile(np.abs(errors), 90) <= 3


def test_onset_of_a_flat_signal_is_within_the_search_range():
    x = np.zeros((2, 99))
    x[1, :50] = np.random.default_rng(2).normal(size=50)
    picked = pick_onset(x, 30)
    assert ((picked >= 69) & (picked <= 96)).all()
