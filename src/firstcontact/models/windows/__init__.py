"""Window models: estimators that learn from signals of one length.

Each file holds one estimator.
"""
