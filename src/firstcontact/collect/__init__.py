"""Collecting labelled data: calibration, the guided protocol, independent checks."""
