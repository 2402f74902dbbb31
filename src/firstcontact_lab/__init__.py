"""Experiments with the package ``firstcontact``: studies, reports, pre-training and benchmarks."""
