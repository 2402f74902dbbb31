"""Access to the compiled functions of detection, live estimates and the twin (C sources in ``c/``).

The package cannot work without them: NumPy and plain Python would be too slow.
"""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

from firstcontact.core._errors import InputError
from firstcontact.core._extras import _CLONE


def _is_stale(built: Path) -> bool:
    firmware = _CLONE / "firmware" / "core"
    sources = [*Path(__file__).with_name("c").glob("*.[ch]"), *firmware.glob("fc_c*.[ch]")]
    return any(source.stat().st_mtime > built.stat().st_mtime for source in sources)


def _load() -> ModuleType | str:
    """Return the module, or the reason why it cannot be used."""
    try:
        module = import_module("firstcontact.core._compiled")
    except ImportError:
        return (
            "the compiled functions of this package are missing: install a C compiler and the "
            "headers of Python (Debian: gcc libc6-dev python3-dev), then this package again"
        )
    # Only in a checkout can sources change after the build: what an installer writes has times
    # without meaning.
    if (_CLONE / "pyproject.toml").is_file() and _is_stale(Path(str(module.__file__))):
        return (
            "the compiled functions of this package are older than their C sources: install the "
            "package again, with pip install --editable ."
        )
    return module


_compiled = _load()


def kernels() -> Any:
    """Return the module of the compiled functions.

    Raises
    ------
    InputError
        They are missing, or older than their sources.
    """
    if isinstance(_compiled, str):
        raise InputError(_compiled)
    return _compiled
