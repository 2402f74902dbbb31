"""Findings of a study: results, figures, and reasons why results are missing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from firstcontact_lab.report.results import NOTHING, Entry, SubjectResults


@dataclass(frozen=True, slots=True)
class Figure:
    """Figure of a report."""

    key: str
    title: str
    caption: str
    image: str


@dataclass(frozen=True, slots=True)
class PartResult:
    """Result of one part of a study."""

    entries: Sequence[Entry] = ()
    figures: Sequence[Figure] = ()
    left_out: Sequence[str] = ()

    @property
    def results(self) -> SubjectResults:
        """Results that contain the entries of this part and nothing else."""
        return NOTHING.replace(self.entries) if self.entries else NOTHING


@dataclass(slots=True)
class Findings:
    """Findings of one subject (dataset under study)."""

    name: str
    results: SubjectResults = NOTHING
    figures: dict[str, dict[str, Figure]] = field(default_factory=dict)
    left_out: list[str] = field(default_factory=list)

    @property
    def title(self) -> str:
        """Name of the subject for readers."""
        return self.name.replace("-", " ").capitalize()

    def add(self, part: str, result: PartResult) -> None:
        """Add the result of a part."""
        self.results = self.results.replace(result.entries)
        figures = self.figures.setdefault(part, {})
        for figure in result.figures:
            figures.pop(figure.key, None)
            figures[figure.key] = figure
        self.left_out += [why for why in result.left_out if why not in self.left_out]
