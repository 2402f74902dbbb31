"""Access to the compiled kernels of live detection and estimation (C sources in ``c/``)."""

from __future__ import annotations

from importlib import import_module
from types import ModuleType

_compiled: ModuleType | None
try:
    _compiled = import_module("firstcontact.core._compiled")
except ImportError:
    _compiled = None


def kernels() -> ModuleType | None:
    """Return the compiled kernels; None if they were not built. NumPy then computes the same."""
    return _compiled
