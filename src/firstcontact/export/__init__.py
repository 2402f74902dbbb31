"""Export of trained models as a C99 library, an ONNX graph, or an image for a hand's firmware."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
