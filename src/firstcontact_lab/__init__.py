"""Experiments with the package ``firstcontact``: studies, reports, pretraining and benchmarks."""
