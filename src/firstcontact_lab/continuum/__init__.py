"""Continuum model of a touch, to check the twin: bodies of finite elements, and their motion."""
