"""Export of trained models: a C99 library, ONNX graphs, or an image for the hand's firmware.

A model is a list of *steps*, which turn a window into a prediction. A *kernel* is the C function
that computes one kind of step. Detector and network are the chain (:mod:`firstcontact.chain`).
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
