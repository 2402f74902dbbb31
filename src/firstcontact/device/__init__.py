"""Sources of samples behind one interface, and the wire protocol of devices."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
