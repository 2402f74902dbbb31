"""Stiffness of an object from the first 15 ms after one finger touches it."""

import lazy_loader

__version__ = "0.1.0"

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
# A star import is not to replace the builtin.
__all__.remove("open")
