"""Grasp policies, one per file, and their registry."""
