"""Conformance checks for registered classes of all kinds, as functions with plain asserts."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
