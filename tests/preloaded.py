"""Modules and compiled functions that the fork server has before it forks programs."""

from forked_children import load

load()
