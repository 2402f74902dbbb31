"""Checks that a detector, estimator, policy, hand or source behaves as the package expects."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
