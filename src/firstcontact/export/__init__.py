"""Export of trained models: C99 library, ONNX graph, or flash image for a hand's processor."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
