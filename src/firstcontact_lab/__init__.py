"""Experiments with the instrument: studies, reports, pretraining and benchmarks."""
