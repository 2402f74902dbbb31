"""Words for the accepted distance of a contact: it depends on how late a label may be."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from firstcontact.models import TOLERANCE
from firstcontact_lab.report.results.study import SubjectResults


@dataclass(frozen=True, slots=True)
class Accepted:
    """Which placements and triggers count, in ms.

    Parameters
    ----------
    early
        How much earlier than its label a contact may be.
    tolerance
        How far from the contact it may be placed.
    """

    early: float = 0.0
    tolerance: float = 1e3 * TOLERANCE

    @classmethod
    def of(cls, found: Sequence[SubjectResults]) -> Accepted:
        """As in a study's results; all its subjects have the same."""
        return cls(max((results.contact.about.early_ms or 0.0 for results in found), default=0.0))

    @property
    def place(self) -> str:
        """What times count from."""
        return "label" if self.early else "known contact"

    @property
    def placed(self) -> str:
        """Short, after "placed"."""
        if not self.early:
            return f"within ±{self.tolerance:g} ms"
        return f"−{self.early + self.tolerance:g} to +{self.tolerance:g} ms from its label"

    @property
    def placed_fully(self) -> str:
        """As a part of a sentence, after "placing the contact"."""
        if not self.early:
            return f"within ±{self.tolerance:g} ms of the known contact"
        return (
            f"from {self.early + self.tolerance:g} ms before its label, which may come up to "
            f"{self.early:g} ms late, to {self.tolerance:g} ms after it"
        )

    @property
    def decided(self) -> str:
        """Short, after "decided"."""
        if not self.early:
            return f"within {self.tolerance:g} ms"
        return f"−{self.early:g} to +{self.tolerance:g} ms from its label"

    @property
    def decided_fully(self) -> str:
        """As a part of a sentence, after "the trigger came"."""
        if not self.early:
            late = f"{self.tolerance:g} ms after it"
            return f"no earlier than the known contact and no later than {late}"
        return f"from {self.early:g} ms before its label to {self.tolerance:g} ms after it"
