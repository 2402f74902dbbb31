"""Options of :func:`firstcontact.train`, checked before the training begins."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from firstcontact.core import ArgumentError, Dataset
from firstcontact.core.installation import require_extra
from firstcontact.core.physics import is_same_rate
from firstcontact.core.quantity import PHYSICAL
from firstcontact.models.estimator import Estimator, EstimatorInfo
from firstcontact.models.labelled_data import DURATION
from firstcontact.models.model_file import pretrained
from firstcontact.models.registry import ESTIMATORS, find_estimator
from firstcontact.models.values import Task
from firstcontact.recording.settings import given_rate
from firstcontact.signal import samples_in

#: Number of random seeds.
MOST_SEEDS = 1 << 32


@dataclass(frozen=True, slots=True)
class Plan:
    """Checked options of one training.

    ``durations`` are lengths of windows, s; ``rate`` is in Hz.
    """

    estimator: object
    kind: type[EstimatorInfo]
    task: Task
    durations: tuple[float, ...]
    level: float
    rate: float | None
    seed: int
    #: True if the user chose an estimator, a task or windows, which then predict by default.
    is_explicit: bool

    @property
    def learns_windows(self) -> bool:
        return issubclass(self.kind, Estimator)

    def model_rate(self, data: Dataset) -> float | None:
        """Return the sampling rate to which all pinches are resampled, Hz; None to keep theirs.

        All predictors of a model use the same rate.
        """
        if self.rate is None and (has_shore_a(data) or not self.learns_windows):
            return pretrained().rate
        if self.rate is None and data.quantity in PHYSICAL:
            return min(pretrained().rate, data.layout.rate)
        return self.rate

    def check_sizes(self, rate: float) -> None:
        """Raise ArgumentError if two windows have equally many samples at this rate, Hz."""
        sizes = [samples_in(length, rate) for length in self.durations]
        if len(set(sizes)) < len(sizes):
            raise ArgumentError(
                f"two lengths of windows have the same number of samples at {rate:g} Hz: leave one "
                "of them out",
                parameter="windows",
            )


def make_plan(
    estimator: object,
    task: Task | str,
    windows: float | Sequence[float],
    level: float,
    rate: float | None,
    seed: int,
) -> Plan:
    """Check the options of a training, which are those of :func:`firstcontact.train`.

    Raise ArgumentError for a wrong option. The error names the parameter.
    """
    durations: list[float] = np.atleast_1d(windows).tolist()
    is_explicit = estimator is not None or task != Task.REGRESSION or durations != [DURATION]
    estimator = ESTIMATORS.default if estimator is None else estimator
    kind = find_estimator(estimator)
    require_extra(kind)
    check_windows(durations)
    check_seed(seed)
    if not 0.5 <= level <= 0.99:
        raise ArgumentError(
            f"the level of the intervals is {level:g}: give 0.5 to 0.99", parameter="level"
        )
    if rate is not None:
        given_rate(rate)
    if task not in tuple(Task):
        raise ArgumentError(
            f"{task!r} is not a task: choose one of {', '.join(Task)}", parameter="task"
        )
    if not issubclass(kind, Estimator):
        _check_network_options(task, durations, level, rate)
        durations = []
    lengths = tuple(sorted(durations))
    return Plan(estimator, kind, Task(task), lengths, level, rate, seed, is_explicit)


def _check_network_options(
    task: str, windows: Sequence[float], level: float, rate: float | None
) -> None:
    base = pretrained()
    is_other_rate = rate is not None and not is_same_rate(rate, base.rate)
    refusals = {
        "task": (task != Task.REGRESSION, "regression"),
        "windows": (tuple(windows) != (DURATION,), "predictions from 2 to 15 ms after a contact"),
        "level": (level != base.level, f"intervals of the level {base.level:g}"),
        "rate": (is_other_rate, f"samples at {base.rate:g} Hz"),
    }
    for parameter, (is_refused, supported) in refusals.items():
        if is_refused:
            raise ArgumentError(
                f"the network supports only {supported}: leave out the {parameter}",
                parameter=parameter,
            )


def has_shore_a(dataset: Dataset) -> bool:
    return bool(np.isfinite(dataset.shore_a).any())


def check_windows(windows: Sequence[float]) -> None:
    """Raise ArgumentError unless all window lengths lie between 1 ms and 1 s."""
    if not windows or not all(0.001 <= length <= 1.0 for length in windows):
        given = ", ".join(f"{1e3 * length:g} ms" for length in windows) or "not given"
        raise ArgumentError(
            f"the lengths of windows are {given}: give one or more from 1 ms to 1 s",
            parameter="windows",
        )


def check_seed(seed: int) -> None:
    """Raise ArgumentError if scikit-learn does not accept this random seed."""
    if not 0 <= seed < MOST_SEEDS:
        raise ArgumentError(
            f"the seed is {seed}: give a whole number from 0 to {MOST_SEEDS - 1}", parameter="seed"
        )
