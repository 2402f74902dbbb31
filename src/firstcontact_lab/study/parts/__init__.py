"""The parts of a study, one file each: from a subject to an outcome."""
