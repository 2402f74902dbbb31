"""Window models: estimators that learn from signals of one length, one per file."""
