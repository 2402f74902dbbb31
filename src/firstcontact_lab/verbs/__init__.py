"""Verbs of the lab, which join the command line by entry points."""
