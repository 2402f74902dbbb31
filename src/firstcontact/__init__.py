"""Estimates of an object's stiffness from the first 15 ms after one finger touches it."""

from typing import Any

import lazy_loader

_public_name, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
# A star import is not to replace the builtin.
__all__.remove("open")


def __getattr__(name: str) -> Any:
    if name != "__version__":
        return _public_name(name)
    # Of the installed package, so that only pyproject.toml has the number.
    from importlib.metadata import version

    return version(__name__)
