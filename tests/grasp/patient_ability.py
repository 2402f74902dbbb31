"""Ability Hand for tests whose emulated hand may answer late on a busy machine."""

from __future__ import annotations

from firstcontact.grasp import _ability

#: Longest wait on a busy machine, s.
_ability.LOST = 60.0


class PatientAbilityHand(_ability.AbilityHand):
    """Ability Hand that a separate process imports from this module."""
