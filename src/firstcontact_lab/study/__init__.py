"""The study: splits, metrics, figures, report."""
