"""Contact detectors, one per file. They find the sample at which a finger touches an object."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
