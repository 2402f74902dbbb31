"""The chain in C: samples in, closings, contacts and estimates out."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
