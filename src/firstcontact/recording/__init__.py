"""Recordings as MCAP files: their writer, a reader that tolerates damage, importers, exporters."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
