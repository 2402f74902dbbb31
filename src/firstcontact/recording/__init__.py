"""Recordings as MCAP files: a writer, a reader that tolerates damage, importers and exporters."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
