"""Stiffness of an object from the first 15 ms after one finger touches it."""

__version__ = "0.1.0"
