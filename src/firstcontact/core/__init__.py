"""Basic types that all rooms (subpackages) share: samples, labels, pinches, estimates, errors."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
