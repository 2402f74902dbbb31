"""Trained models in other languages: C99 with its kernels, ONNX, images for the hand."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
