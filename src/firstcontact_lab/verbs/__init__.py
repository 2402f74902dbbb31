"""Verbs of the lab. Entry points add them to the command line."""
