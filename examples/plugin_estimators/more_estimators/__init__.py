"""Estimators of firstcontact from another package: Gaussian process and MiniRocket."""
