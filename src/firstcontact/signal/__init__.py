"""Filters and windows; streaming forms carry their state."""
