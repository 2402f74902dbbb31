"""Parts of the installation: optional packages (extras), compiled functions, and versions."""

from __future__ import annotations

import os
import platform
import shlex
import sys
from collections.abc import Iterable
from contextlib import suppress
from functools import cache
from importlib import import_module, metadata
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType
from typing import Any

from firstcontact.core._errors import InputError

#: Packages whose versions a result depends on.
PACKAGES = (
    "firstcontact",
    "numpy",
    "scipy",
    "scikit-learn",
    "skops",
    "torch",
    "onnxruntime",
    "matplotlib",
)
#: Root of the clone that holds this file, unless the package is installed as a copy.
_CLONE = Path(__file__).parents[3]


def require_extra(entry: Any) -> None:
    """Check the ``modules`` of a registered entry; its ``extra`` installs them."""
    require_modules(entry.extra, *entry.modules)


def require_modules(extra: str, *modules: str) -> None:
    """Raise an error with the install command if any of these modules is missing."""
    missing = missing_modules(modules)
    if missing:
        raise InputError(
            f"this command or call needs {', '.join(missing)}, which is not installed: "
            f"{install_command(extra)}"
        )


def missing_modules(modules: Iterable[str]) -> list[str]:
    """Return the modules of this list that are not installed."""
    return [m for m in modules if find_spec(m) is None]


def install_command(extra: str) -> str:
    """Return the command that installs an extra of this package."""
    pip = [sys.executable, "-m", "pip", "install"]
    if (_CLONE / "pyproject.toml").is_file():
        return shlex.join([*pip, "-e", f"{_CLONE}[{extra}]"])
    return f"{shlex.join([*pip, f'.[{extra}]'])} (in a clone of firstcontact)"


def import_onnxruntime() -> Any:
    """Import ONNX Runtime with its telemetry switched off, and return the module."""
    os.environ["ORT_DISABLE_TELEMETRY"] = "1"
    import onnxruntime

    onnxruntime.disable_telemetry_events()  # the caller's program may have imported it before
    return onnxruntime


@cache  # reading a package's metadata takes milliseconds, and pages are rendered again and again
def installed_versions() -> dict[str, str]:
    """Return the versions of Python and of the installed packages that results depend on."""
    versions = {"python": platform.python_version()}
    for package in PACKAGES:
        with suppress(metadata.PackageNotFoundError):
            versions[package] = metadata.version(package)
    return versions


def kernels() -> Any:
    """Return the module of the compiled functions, whose C sources are in ``c/``."""
    return _load_kernels()


@cache
def _load_kernels() -> ModuleType:
    try:
        module = import_module("firstcontact.core._compiled")
    except ImportError as error:
        raise InputError(
            "the compiled functions of this package are missing: install a C compiler and the "
            "headers of Python (Debian: gcc libc6-dev python3-dev), then this package again"
        ) from error
    built = Path(str(module.__file__))
    package = Path(__file__).parents[1]
    firmware = _CLONE / "firmware" / "core"
    own = [*package.glob("core/c/*.[ch]"), *firmware.glob("fc_c*.[ch]")]
    chain = [*package.glob("chain/c/*.[ch]"), *package.glob("core/c/arrays.[ch]")]
    # Only in a checkout can sources change after the build: what an installer writes has times
    # without meaning.
    is_clone = (_CLONE / "pyproject.toml").is_file()
    for binary, sources in ((built, own), (package / "chain" / built.name, chain)):
        if is_clone and binary.exists():
            age = binary.stat().st_mtime
            if any(source.stat().st_mtime > age for source in sources):
                raise InputError(
                    "the compiled functions of this package are older than their C sources: "
                    "install the package again, with pip install --editable ."
                )
    return module
