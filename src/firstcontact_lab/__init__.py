"""Experiments with the package ``firstcontact``: studies, reports and pre-training."""
