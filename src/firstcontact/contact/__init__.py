"""Contact detectors, one per file. They find when a finger touches, from its vibration."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
