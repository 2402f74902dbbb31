"""Ability Hand for tests whose emulated hand may answer late on a busy machine."""

from firstcontact.grasp import ability

#: Longest wait on a busy machine, s.
ability.LOST = 60.0


class PatientAbilityHand(ability.AbilityHand):
    """Ability Hand that a separate process imports from this module."""
