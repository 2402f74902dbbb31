"""Parts of a study, the datasets that they measure (subjects), and the settings of a study."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from firstcontact.contact import DETECTORS
from firstcontact.core import Contact, Dataset
from firstcontact.jobs import Runner
from firstcontact.models import ESTIMATORS, Windows
from firstcontact.models.labelled_data import LabelledWindows, distinct_specimens, label_windows
from firstcontact.models.rig.network_estimator import Adapted
from firstcontact.signal import contact_windows
from firstcontact_lab.report.findings import Figure, PartResult
from firstcontact_lab.report.results import Field, SubjectResults
from firstcontact_lab.report.tables import Row, Table

T = TypeVar("T")
Values = NDArray[np.float64]
Contacts = tuple[Contact | None, ...]
#: Windows, and a mask of the pinches that have a window.
Cut = tuple[Windows, NDArray[np.bool_]]
#: Results of each subject by the title of the subject.
Subjects = Mapping[str, SubjectResults]
#: Functions that make a table of one subject, or one function that makes all of them.
Tables = (
    Sequence[Callable[[SubjectResults], Table | None]]
    | Callable[[SubjectResults], Sequence[Table | None]]
)


@dataclass(frozen=True, slots=True)
class StudySettings:
    block_pinches: int = 500
    object_pinches: int = 50
    durations: tuple[float, ...] = (0.002, 0.003, 0.005, 0.008, 0.010, 0.015)
    folds: int = 5
    brief: bool = False
    calls: int = 2_000
    detector: str = DETECTORS.default
    early: float = 0.0
    rig_seeds: tuple[int, ...] = (601, 602, 603, 604, 605, 606)
    delays: str = ""
    waveforms: str = ""
    parts: tuple[str, ...] = ()
    seed: int = 0
    workers: int = 2

    def quick(self) -> StudySettings:
        """Return settings of a quick trial that runs every part. Do not quote its numbers."""
        return replace(
            self,
            block_pinches=20,
            object_pinches=5,
            durations=(0.003, 0.008, 0.015),
            folds=3,
            brief=True,
            calls=500,
            rig_seeds=(601,),
        )

    def options(self, estimator: str) -> Mapping[str, Any]:
        return ESTIMATORS[estimator].quick if self.brief else {}


@dataclass(slots=True, eq=False)
class Subject:
    """Dataset under study, with results of those parts of the study that already ran."""

    name: str
    dataset: Dataset
    detections: Contacts = ()
    predictions: dict[tuple[str, str], tuple[LabelledWindows, Values]] = field(default_factory=dict)
    set_name: str = "recordings"
    adapted: Adapted | None = None
    _cut: dict[tuple[object, ...], Cut] = field(default_factory=dict, repr=False)

    @property
    def truth(self) -> Contacts:
        """True first contact of each pinch, from the contact strip or label; None if unknown."""
        return tuple(p.first for p in self.dataset.pinches)

    @property
    def has_known_contacts(self) -> bool:
        return any(contact is not None for contact in self.truth)

    @property
    def starts(self) -> Contacts:
        """Contact at which the window of each pinch starts.

        It is the detected contact, or the true one if no detector was run.
        """
        return self.detections or self.truth

    @property
    def levels(self) -> Values:
        """Distinct values of Shore A among the training pinches."""
        shore = self.dataset.shore_a[~self.dataset.test]
        return np.unique(shore[np.isfinite(shore)])

    def windows(self, duration: float, contacts: Contacts | None = None) -> LabelledWindows:
        """Return windows of ``duration`` s, labelled by Shore A.

        Windows start at ``contacts``, by default at :attr:`starts`.
        """
        return self.labelled_windows(duration, self.dataset.shore_a, contacts)

    def labelled_windows(
        self,
        duration: float,
        target: Values,
        contacts: Contacts | None = None,
        *,
        conditioned: bool = True,
    ) -> LabelledWindows:
        """Return windows of ``duration`` s, labelled by ``target``, which has one value per pinch.

        Windows start at ``contacts``, by default at :attr:`starts`. With ``conditioned`` the signal
        is smoothed as in the paper.
        """
        cut = self.cut_windows(duration, contacts, conditioned=conditioned)
        data = label_windows(self.dataset, *cut, target)
        return replace(data, specimens=distinct_specimens(self.dataset)[data.rows])

    def cut_windows(
        self, duration: float, contacts: Contacts | None = None, *, conditioned: bool = True
    ) -> Cut:
        """Return windows of ``duration`` s, and a mask of the pinches that have a complete window.

        Windows start at ``contacts``, by default at :attr:`starts`. With ``conditioned`` the signal
        is smoothed as in the paper.
        """
        starts = self.starts if contacts is None else contacts
        key = duration, conditioned, tuple(starts)
        if key not in self._cut:
            self._cut[key] = contact_windows(
                self.dataset, starts, duration, conditioned=conditioned
            )
        return self._cut[key]


Measure = Callable[[Subject, StudySettings, Runner], PartResult]


@dataclass(frozen=True, slots=True)
class Step:
    """One measurement of a part of a study."""

    title: str
    run: Measure
    #: Slow steps run last, after the other steps of all subjects.
    late: bool = False
    #: The study ends if a vital step fails.
    vital: bool = False
    #: Time relative to other steps, to estimate the remaining time.
    cost: float = 1.0


def with_ranks(measure: Measure) -> Measure:
    """Return a version of ``measure`` that does nothing for a dataset without hardness ranks."""

    def measure_ranks(subject: Subject, settings: StudySettings, runner: Runner) -> PartResult:
        if not np.isfinite(subject.dataset.hardness_rank).any():
            return PartResult()
        return measure(subject, settings, runner)

    return measure_ranks


@dataclass(frozen=True, slots=True)
class Part:
    """Topic of a study: its measurements, figures, tables, rows and text."""

    name: str
    title: str
    steps: Sequence[Step] = ()
    text: Callable[[Subjects], str] = lambda subjects: ""
    #: A missing result is None or a table without lines.
    tables: Tables = ()
    rows: Callable[[Subjects], Sequence[Row[SubjectResults]]] = lambda subjects: ()
    #: Columns of the first table that the report shows; all if empty.
    columns: Sequence[str] = ()
    #: Open figures. Without them, the first figure and the first table of each subject are open.
    figures: Callable[[Subjects], Sequence[Figure]] = lambda subjects: ()
    #: Parts that run first, because the measurements use their results.
    needs: Sequence[str] = ("data", "contacts")
    by_default: bool = True

    def made_tables(self, results: SubjectResults) -> list[Table]:
        made = self.tables(results) if callable(self.tables) else [t(results) for t in self.tables]
        return [table for table in made if table and table.lines]


def titled(subjects: Subjects, field: Field[T | None], draw: Callable[[T], Figure]) -> list[Figure]:
    present = {
        title: value for title, results in subjects.items() if (value := results[field]) is not None
    }
    return [
        replace(figure, title=f"{figure.title}, {title}")
        for title, value in present.items()
        for figure in (draw(value),)
    ]


def distinct(values: Iterable[str]) -> list[str]:
    return list(dict.fromkeys(values))
