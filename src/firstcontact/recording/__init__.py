"""Recordings: one MCAP file each, a writer that survives being killed, a tolerant reader."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
