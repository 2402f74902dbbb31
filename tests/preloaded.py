"""Modules and compiled functions that the fork server loads before it forks programs."""

from forked_children import load

load()
