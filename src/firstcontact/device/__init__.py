"""Sources of live samples (serial, sound, LSL, replay), and the devices' serial protocol."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
