"""Scores of detection and estimation on twin pinches whose noise differs from training."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from firstcontact.contact import DETECTORS, Detector, make_detector
from firstcontact.core import Dataset, Record, Serial
from firstcontact.models import (
    DURATION,
    ESTIMATORS,
    DetectionScores,
    Fit,
    Task,
    WindowModel,
    detect_alignment,
    fit_model,
    found_as_live,
    labelled_windows,
    score_detector,
)
from firstcontact_lab.report.results import Field, SubjectResults
from firstcontact_lab.report.tables import Cell, Row, Table, matrix
from firstcontact_lab.study.part import Part, Subjects

#: Header text that names the noise of the pinches (``simulate --noise``).
SAID = "noise of "


class NoiseScores(Record, frozen=True, kw_only=True):
    """Scores on twin pinches with one kind of noise, for models trained with the usual noise."""

    noise: str
    detectors: dict[str, DetectionScores]
    estimator: str
    estimated: int
    rmse: float | None = None
    rmse_unseen: float | None = None


class NoiseScorer:
    """Scorer for pinches with any noise. It trains detectors and an estimator once, on the twin."""

    def __init__(
        self, twin: Dataset, seed: int = 0, say: Callable[[str], object] = lambda line: None
    ) -> None:
        self._say = say
        say("training on the twin, to score twin pinches with other noise")
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

    def score(self, name: str, dataset: Dataset) -> NoiseScores:
        """Return the scores on some pinches that were not used for training."""
        self._say(f"{name}: {len(dataset)} pinches of the twin")
        windows = labelled_windows(
            dataset, detect_alignment(dataset, self._main).contacts, DURATION, dataset.shore_a
        )
        squares = (self._model.predict(windows.X) - windows.y) ** 2
        noise_note = next((note for note in dataset.notes if note.startswith(SAID)), "as modelled")
        return NoiseScores(
            noise=noise_note.partition(" in place of")[0],
            detectors={
                kind: score_detector(detector, dataset)
                for kind, detector in self._detectors.items()
            },
            estimator=ESTIMATORS.default,
            estimated=len(windows),
            rmse=_root(squares[~windows.test]),
            rmse_unseen=_root(squares[windows.test]),
        )


def _root(squares: NDArray[np.float64]) -> float | None:
    return float(np.sqrt(squares.mean())) if len(squares) else None


NOISE = Field.optional("noise", NoiseScores)
_ROWS: Sequence[Row[DetectionScores]] = (
    Row("pinches", lambda s: s.n),
    Row("placed within 3 ms", lambda s: s.pinch_success, "share"),
    Row("decided within 3 ms", lambda s: s.decided_within_3_ms, "share"),
    Row("false alarms a minute", lambda s: s.false_alarms_per_minute, "rate"),
    Row("delay, median", lambda s: s.delay_ms.median if s.delay_ms else None, "ms"),
    Row("95th percentile", lambda s: s.delay_ms.p95 if s.delay_ms else None, "ms"),
)
_ERRORS: Sequence[Row[NoiseScores]] = (
    Row("15 ms: RMSE, Shore A", lambda s: s.rmse, "shore"),
    Row("unseen objects", lambda s: s.rmse_unseen, "shore"),
)


def noise_tables(subjects: Subjects) -> list[Table]:
    """Return tables of detection and of errors: twin pinches, one line for each noise."""
    noises = {name.replace("_", " "): r[NOISE] for name, r in subjects.items() if r[NOISE]}
    caption = (
        "Twin results: the same simulated pinches, with the modelled noise of the electronics, and "
        "with the noise of real sensors at rest. The noise of the motor is modelled in each. "
        "Detectors and the estimator were trained on other pinches of other rigs, with the "
        "modelled noise."
    )
    detection = matrix(
        caption,
        _ROWS,
        [
            (Cell(f"{name}, {DETECTORS[kind].title if kind in DETECTORS else kind}"), scores, False)
            for name, record in noises.items()
            for kind, scores in (record.detectors if record else {}).items()
        ],
    )
    caption = "Errors of estimates at the contacts of the default detector."
    errors = matrix(
        caption, _ERRORS, [(Cell(name), record, False) for name, record in noises.items()]
    )
    return [table for table in (detection, errors) if table]


def _table(place: int) -> Callable[[SubjectResults], Table | None]:
    def make(results: SubjectResults) -> Table | None:
        tables = noise_tables({"here": results})
        return tables[place] if place < len(tables) else None

    return make


NOISE_PART = Part("noise", "The twin with other noises", (), tables=[_table(0), _table(1)])
