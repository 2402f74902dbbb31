"""A slip detector that is declared: it knows of a slip so long after it began."""

from __future__ import annotations

from firstcontact.twin import GraspPlant


class SlipWatch:
    """Tells of a slip its latency after it began, and again each latency while it goes on.

    Parameters
    ----------
    latency
        s.
    """

    def __init__(self, latency: float) -> None:
        self._latency = latency
        self._told = -float("inf")

    def slips(self, plant: GraspPlant) -> bool:
        """Whether it says now that the object slips."""
        since = plant.slipping_since
        if since is None or plant.now - max(since, self._told) < self._latency:
            return False
        self._told = plant.now
        return True
