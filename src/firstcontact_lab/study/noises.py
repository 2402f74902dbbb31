"""The twin's pinches over other noises: found and estimated by what learned over its own."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from firstcontact.contact import DETECTORS, Detector, make_detector
from firstcontact.core import Dataset, Serial
from firstcontact.models import (
    DURATION,
    ESTIMATORS,
    Fit,
    Task,
    WindowModel,
    fit_model,
    found,
    found_as_live,
    labelled_windows,
    score_detector,
)
from firstcontact_lab.report.results.sets import NoiseFound

#: How a header says what lies under its pinches (``simulate --noise``).
SAID = "noise of "


class NoiseScorer:
    """Detectors and the default estimator, learned once from the twin.

    Parameters
    ----------
    twin
        To learn from.
    seed
        Of folds and trainings.
    say
        Told what is being done.
    """

    def __init__(
        self, twin: Dataset, seed: int = 0, say: Callable[[str], object] = lambda line: None
    ) -> None:
        self._say = say
        say("learning from the twin, for other noises under it")
        self._detectors: dict[str, Detector] = {
            name: make_detector(name).fit(twin) for name in DETECTORS
        }
        contacts = found_as_live(twin, self._main, seed, Serial())
        windows = labelled_windows(twin, contacts.contacts, DURATION, twin.shore_a)
        learn = windows.take(~windows.test)
        self._model: WindowModel = fit_model(
            Fit(ESTIMATORS.default, Task.REGRESSION, learn, learn.X[:0], seed)
        )

    @property
    def _main(self) -> Detector:
        return self._detectors[DETECTORS.default]

    def score(self, name: str, dataset: Dataset) -> NoiseFound:
        """Pinches that nothing was learned from.

        Parameters
        ----------
        name
            Theirs, for what is said.
        dataset
            At the rate of what was learned from.
        """
        self._say(f"{name}: {len(dataset)} pinches of the twin")
        asked = labelled_windows(
            dataset, found(dataset, self._main).contacts, DURATION, dataset.shore_a
        )
        squares = (self._model.predict(asked.X) - asked.y) ** 2
        said = next((note for note in dataset.notes if note.startswith(SAID)), "as modelled")
        return NoiseFound(
            noise=said.partition(" in place of")[0],
            detectors={
                kind: score_detector(detector, dataset)
                for kind, detector in self._detectors.items()
            },
            estimator=ESTIMATORS.default,
            estimated=len(asked),
            rmse=_root(squares[~asked.test]),
            rmse_unseen=_root(squares[asked.test]),
        )


def _root(squares: NDArray[np.float64]) -> float | None:
    return float(np.sqrt(squares.mean())) if len(squares) else None
