"""Parallel jobs on this computer or on a Dask cluster, and child processes."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
