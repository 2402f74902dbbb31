"""Contact detectors, one a file."""
