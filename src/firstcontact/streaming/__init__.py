"""Live sessions: contacts and estimates in real time, shown on the page and other outputs."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
