"""Figures of the grasp report; matplotlib is imported when one is drawn."""
