"""How good answers are that come at any time after a contact, and off the blocks."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from firstcontact.core import Record
from firstcontact.models import AnytimeScores, Bounded, Ends


class FixedWindow(Record, frozen=True, kw_only=True):
    """The default estimator's whole window, on those of the same pinches that have one."""

    estimator: str
    n: int
    rmse: float
    intervals: dict[str, Ends]


class AnytimeResults(AnytimeScores, frozen=True, kw_only=True):
    """Of unseen objects, or of blocks of other sessions where there are none (``asked``).

    ``before_second``: share of ``with_second`` pinches of any role with an answer before the
    second contact, all delays counted. ``too_short``: pinches asked about whose second contact
    came before any answer; they have no error. ``way``: how the rig is known; ``level``: share
    that intervals are to hold.
    """

    asked: str
    level: float
    way: str
    too_short: int
    before_second: float | None = None
    with_second: int | None = None
    fixed: FixedWindow | None = None
    blocks: AnytimeScores | None = None


class OffBlocks(Record, frozen=True, kw_only=True):
    """An estimator off its training blocks: RMSE and bias in Shore A over ``sets`` rigs.

    ``accuracy``: share of blocks whose answer lies nearest to their own level. ``options``:
    fields with which it learned, where they are not the usual ones.
    """

    sets: int
    objects: float
    three_pinches: float
    bias_softest: float
    bias_hardest: float
    blocks: float | None = None
    accuracy: float | None = None
    other_hand: float | None = None
    level_left_out: float | None = None
    options: dict[str, Any] | None = None
    intervals: dict[str, Ends]

    def bounded(self, name: str) -> Bounded | None:
        """A score with its interval; None where it was not asked for."""
        value: float | None = getattr(self, name)
        return None if value is None else Bounded(value, self.intervals.get(name))


class Generalised(Record, frozen=True, kw_only=True):
    """Estimators on rigs and specimens of their own seeds; one single pinch unless said otherwise.

    ``floor`` learned from the same kinds of object on the very rig. ``ceiling``: what an estimator
    could do that is told the modulus, or the stiffness of the contact. ``pinches``: of each set by
    its use; ``too_short``: share whose second contact left no answer, which nobody is asked about.
    """

    sets: int
    seeds: list[int]
    pinches: dict[str, int]
    too_short: float
    floor: OffBlocks
    ceiling: dict[str, OffBlocks]
    estimators: dict[str, OffBlocks]


#: The in-context network, as people read it; no registry of estimators knows it.
NETWORK_TITLES: Mapping[str, str] = {
    "in_context": "In-context network",
    "in_context_radius": "In-context network, radius told",
}
#: All rows that no registry of estimators knows.
TITLES: Mapping[str, str] = {
    **NETWORK_TITLES,
    "masked": "Default estimator, masked",
    "modulus": "told the modulus",
    "contact_stiffness": "told the contact's stiffness",
}
