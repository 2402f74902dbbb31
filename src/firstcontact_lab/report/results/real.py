"""Recordings with hardness ranks: materials left out, from the first milliseconds."""

from __future__ import annotations

from firstcontact.core import Record
from firstcontact.models import RankCorrelation

#: Lengths of windows that headlines and overviews show, ms.
SHOWN_MS = ("3", "15")


class Reading(Record, frozen=True, kw_only=True):
    """One way to read the windows.

    Parameters
    ----------
    estimator
        Name of it.
    conditioned
        Whether the signal was smoothed and filtered as published, or is as the device sent it.
    known_contacts
        Whether windows start at the contacts of the labels, or where the detector found them.
    n
        Pinches with a window of 15 ms.
    material_held_out
        Balanced accuracy by length in ms: the mean over materials, then over classes.
    """

    estimator: str
    conditioned: bool
    known_contacts: bool
    n: int
    material_held_out: dict[str, float]


class RealMaterial(Record, frozen=True, kw_only=True):
    """One material, left out: accuracy by length in ms, and its mean centroids, Hz."""

    rank: float
    n: int
    accuracy: dict[str, float]
    centroid_hz: float
    conditioned_centroid_hz: float


class RealSet(Record, frozen=True, kw_only=True):
    """What one set of recordings says of the order and the classes of hardness.

    Parameters
    ----------
    n
        Pinches with a window.
    materials
        How many there are.
    material_held_out
        Of the first reading.
    chance
        Balanced accuracy of any constant prediction: all score the same.
    score
        That orders materials and that nothing was fitted to, in words.
    rho, p
        Spearman over materials of that score on the signal as the device sent it.
    most_rho
        What a perfect order would give: materials of one rank are ties.
    conditioned_order
        The same score behind the published conditioning.
    readings
        The first is the one above; the others differ from it in what they say.
    by_material
        Of the first reading.
    """

    n: int
    materials: int
    material_held_out: dict[str, float]
    chance: float
    score: str
    rho: float | None = None
    p: float | None = None
    most_rho: float
    conditioned_order: RankCorrelation
    readings: list[Reading]
    by_material: dict[str, RealMaterial]
