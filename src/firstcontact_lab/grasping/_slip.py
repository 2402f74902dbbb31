"""Ideal slip detector with an assumed latency."""

from __future__ import annotations

from firstcontact.twin import GraspPlant


class SlipWatch:
    """Slip detector that reports a slip one latency after its start, then once every latency."""

    def __init__(self, latency: float) -> None:
        self._latency = latency
        self._told = -float("inf")

    def slips(self, plant: GraspPlant) -> bool:
        """Return True if the detector reports a slip at the plant's newest sample."""
        since = plant.slipping_since
        if since is None or plant.now - max(since, self._told) < self._latency:
            return False
        self._told = plant.now
        return True
