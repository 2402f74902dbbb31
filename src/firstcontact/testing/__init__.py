"""What every registered thing must do, as functions for whoever writes one: plain asserts."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
