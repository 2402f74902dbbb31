"""Filters for streams, resampling, closing speed, and windows of signal after a contact."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
