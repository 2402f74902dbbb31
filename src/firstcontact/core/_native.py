"""Access to the compiled kernels of live's estimates and of the twin (C sources in ``c/``)."""

from __future__ import annotations

import logging
from importlib import import_module
from pathlib import Path
from types import ModuleType

from firstcontact.core._errors import InputError
from firstcontact.core._extras import _CLONE, install_command, missing_modules

_log = logging.getLogger(__name__)


def _is_stale(built: Path) -> bool:
    firmware = _CLONE / "firmware" / "core"
    sources = [*Path(__file__).with_name("c").glob("*.[ch]"), *firmware.glob("fc_c*.[ch]")]
    return any(source.stat().st_mtime > built.stat().st_mtime for source in sources)


def _load() -> ModuleType | None:
    try:
        module = import_module("firstcontact.core._compiled")
    except ImportError:
        return None
    # Only in a checkout can sources change after the build: what an installer writes has times
    # without meaning.
    if (_CLONE / "pyproject.toml").is_file() and _is_stale(Path(str(module.__file__))):
        _log.warning(
            "the compiled C functions are older than their source code, so slower NumPy code "
            "takes their place and live estimates come later: install the package again, with "
            "pip install --editable ."
        )
        return None
    return module


_compiled = _load()


def kernels() -> ModuleType | None:
    """Return the compiled kernels; None if they were not built. NumPy then computes the same."""
    return _compiled


def require_twin() -> None:
    """Raise an error with the remedies if nothing compiled can run the simulated hand.

    Raises
    ------
    InputError
        Neither the kernels nor Numba are there.
    """
    if kernels() is None and missing_modules(["numba"]):
        raise InputError(
            "the simulated hand needs compiled code, and there is none: install a C compiler with "
            "Python's headers and then this package again, or Numba in its place: "
            f"{install_command('twin')}"
        )
