"""Access to the compiled chain."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from firstcontact.core import kernels


def chain_extension() -> Any:
    """Return the compiled module of the chain. InputError says what to install if it is missing."""
    kernels()  # one build makes both modules, and this one has the message
    return import_module("firstcontact.chain._compiled")
