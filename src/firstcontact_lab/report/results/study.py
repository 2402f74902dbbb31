"""Everything that a study finds: a new part adds a record of its own and one field here.

What each key means is told in ``docs/reference/results-json.md``.
"""

from __future__ import annotations

from typing import Any

import msgspec

from firstcontact.core import ByName, Record
from firstcontact.models import InferenceTime
from firstcontact_lab.report.results.anytime import AnytimeResults, Generalised
from firstcontact_lab.report.results.board import BoardTime
from firstcontact_lab.report.results.contact import AnswerTimes, ContactConditions, ContactResults
from firstcontact_lab.report.results.data import DataSummary, Offsets, PeakVoltage
from firstcontact_lab.report.results.hardness import HardnessOrder
from firstcontact_lab.report.results.real import RealSet
from firstcontact_lab.report.results.stiffness import (
    BlockConditions,
    BlockResults,
    InferenceTimes,
    ObjectConditions,
    ObjectResults,
    SecondContact,
    WindowErrors,
    WindowSearch,
)


class SubjectResults(Record, frozen=True, kw_only=True):
    """What is known of one subject; each part of a study fills in fields of its own.

    Fields are keys of ``results.json``. Mappings go by the name of an estimator, or by a Shore A
    level or a length in ms.
    """

    data: DataSummary | None = None
    offset_ms: Offsets | None = None
    contact: ContactResults = ByName({}, ContactConditions())
    answer_ms: AnswerTimes | None = None
    peak_v: dict[str, PeakVoltage] | None = None
    blocks: BlockResults = ByName({}, BlockConditions())
    objects: ObjectResults = ByName({}, ObjectConditions())
    hardness_order: HardnessOrder | None = None
    real: dict[str, RealSet] | None = None
    anytime: AnytimeResults | None = None
    generalise: Generalised | None = None
    window_length_ms: dict[str, dict[str, WindowErrors]] | None = None
    window_length_search: WindowSearch | None = None
    second_contact_in_window: dict[str, SecondContact] | None = None
    inference_us: dict[str, InferenceTimes] | None = None
    anytime_us: InferenceTime | None = None
    board: dict[str, BoardTime] | None = None
    left_out: list[str] | None = None

    @property
    def twin(self) -> bool:
        """Whether its pinches are the twin's."""
        return self.data is not None and self.data.source == "twin"


class StudyRun(Record, frozen=True, kw_only=True):
    """How a study was asked for, and how far it came."""

    command: str
    condition: str
    quick: bool
    started: str
    complete: bool
    stopped: str | None = None
    asked: dict[str, Any] | None = None
    settings: dict[str, Any]
    seed: int


class FirstSubject(SubjectResults, frozen=True, kw_only=True):
    """The first subject, and what there is once a study."""

    seconds: float
    part_seconds: dict[str, float]
    study: StudyRun
    versions: dict[str, str]
    pending: list[str] | None = None


#: ``results.json``: the first subject at the top, others under their names.
StudyResults = ByName[SubjectResults, FirstSubject]

NOTHING = SubjectResults()


def merged(results: SubjectResults, more: SubjectResults) -> SubjectResults:
    """Both; what a later part says stands, beside the entries of other names."""
    changed: dict[str, Any] = {}
    for name in SubjectResults.__struct_fields__:
        before, new = getattr(results, name), getattr(more, name)
        if new is getattr(NOTHING, name):
            continue
        if isinstance(new, ByName):
            new = ByName({**before, **new}, new.about)
        changed[name] = new
    return msgspec.structs.replace(results, **changed)
