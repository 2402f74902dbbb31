"""Grasp modulation: policies, and the hands that they command."""
