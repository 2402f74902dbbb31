"""Estimators and tasks that the tests of all estimators are run with."""

from __future__ import annotations

import pytest

from firstcontact.models import Task, window_estimators

#: Each estimator with each of its tasks. A CNN differs between the two in its last layer alone, and
#: takes longest: its classification is a slow test.
EACH = [
    pytest.param(
        name,
        task,
        marks=[pytest.mark.slow] if (name, task) == ("cnn", Task.CLASSIFICATION) else [],
    )
    for name, kind in window_estimators().items()
    for task in kind.tasks
]
