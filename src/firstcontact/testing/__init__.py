"""Checks that a plug-in (detector, estimator, policy, hand, source) behaves as required."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
