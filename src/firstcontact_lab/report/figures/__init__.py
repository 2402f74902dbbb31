"""Figures of the report, one file each; matplotlib is imported when one is drawn."""
