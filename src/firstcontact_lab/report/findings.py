"""What the parts of a study have found: numbers, figures, and what could not be done."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from firstcontact_lab.report.results.study import NOTHING, SubjectResults, merged


@dataclass(frozen=True, slots=True)
class Figure:
    """A figure of the report.

    Parameters
    ----------
    key
        Same key, same subject: replaces the one before.
    title
        What it shows.
    caption
        How to read it.
    image
        A data URI.
    """

    key: str
    title: str
    caption: str
    image: str


@dataclass(frozen=True, slots=True)
class PartResult:
    """What a part found.

    Parameters
    ----------
    results
        Merged into ``results.json``.
    figures
        For the report.
    left_out
        What the labels did not permit, one sentence each.
    """

    results: SubjectResults = NOTHING
    figures: Sequence[Figure] = ()
    left_out: Sequence[str] = ()


@dataclass(slots=True)
class Findings:
    """What is known of one subject.

    Parameters
    ----------
    name
        Of the subject.
    results
        Its part of ``results.json``.
    figures
        By their key, in the order they came.
    left_out
        What its labels did not permit.
    """

    name: str
    results: SubjectResults = NOTHING
    figures: dict[str, Figure] = field(default_factory=dict)
    left_out: list[str] = field(default_factory=list)

    @property
    def title(self) -> str:
        """Its name as it is written."""
        return self.name.replace("-", " ").capitalize()

    def take(self, result: PartResult) -> None:
        """Merge what a part found."""
        self.results = merged(self.results, result.results)
        self.figures.update({figure.key: figure for figure in result.figures})
        self.left_out += [why for why in result.left_out if why not in self.left_out]
