"""Chain: the package's C code, which turns samples into closings, contacts and estimates."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
