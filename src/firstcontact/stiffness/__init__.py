"""Stiffness estimators, one a file, and the saved-model format."""
