"""Guided recording, import, calibration and self-test of fingertips, and labelling of contacts."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
