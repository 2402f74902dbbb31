"""Touches computed with finite elements, which check the simpler mechanics of the twin."""
