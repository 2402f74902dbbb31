"""Parts of the installation: optional packages (extras), compiled functions, and versions."""

from __future__ import annotations

import os
import platform
import shlex
import sys
import tomllib
from collections.abc import Iterable
from contextlib import suppress
from functools import cache
from hashlib import sha256
from importlib import import_module, metadata
from importlib.util import find_spec
from pathlib import Path
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
CLONE = Path(__file__).parents[3]


def require_extra(entry: Any) -> None:
    """Raise InputError with the install command if a registry's entry needs missing packages."""
    require_modules(entry.extra, *entry.modules)


def require_modules(extra: str, *modules: str) -> None:
    """Raise InputError with the install command of ``extra`` if one of these modules is missing."""
    missing = missing_modules(modules)
    if missing:
        raise InputError(
            f"this command or call needs {', '.join(missing)}, which is not installed: install it "
            f"with {install_command(extra)}"
        )


def missing_modules(modules: Iterable[str]) -> list[str]:
    """Return the modules of this list that are not installed."""
    return [m for m in modules if find_spec(m) is None]


def install_command(extra: str) -> str:
    """Return the pip command that installs an extra (optional packages) of this package."""
    pip = [sys.executable, "-m", "pip", "install"]
    if (CLONE / "pyproject.toml").is_file():
        return shlex.join([*pip, "-e", f"{CLONE}[{extra}]"])
    return f"{shlex.join([*pip, f'.[{extra}]'])} (in a clone of firstcontact)"


def import_onnxruntime() -> Any:
    """Import ONNX Runtime with its telemetry switched off, and return the module."""
    os.environ["ORT_DISABLE_TELEMETRY"] = "1"
    import onnxruntime

    onnxruntime.disable_telemetry_events()  # the caller's program may have imported it before
    return onnxruntime


@cache  # reading a package's metadata takes milliseconds, and pages are rendered again and again
def installed_versions() -> dict[str, str]:
    """Return version texts by name, of Python and the installed packages that results depend on."""
    versions = {"python": platform.python_version()}
    for package in PACKAGES:
        with suppress(metadata.PackageNotFoundError):
            versions[package] = metadata.version(package)
    return versions


@cache
def load_compiled(name: str) -> Any:
    """Import a module of compiled functions, such as ``firstcontact.twin._compiled``.

    Raises InputError if it is missing, or was compiled from other C sources than this clone has.
    """
    try:
        module = import_module(name)
    except ImportError as error:
        raise InputError(
            "the compiled functions of this package are missing: install a C compiler and the "
            "headers of Python (Debian: gcc libc6-dev python3-dev), then this package again"
        ) from error
    # Only in a checkout can sources change after the build.
    if (project := CLONE / "pyproject.toml").is_file():
        tree = tomllib.loads(project.read_text(encoding="utf-8"))
        for extension in tree["tool"]["setuptools"]["ext-modules"]:
            if extension["name"] != name:
                continue
            files = [CLONE / file for file in (*extension["sources"], *extension["depends"])]
            digest = sha256(b"".join(file.read_bytes() for file in files)).hexdigest()
            *folders, _ = extension["name"].split(".")
            binary = CLONE.joinpath("src", *folders, Path(str(module.__file__)).name)
            if binary.exists() and digest.encode() not in binary.read_bytes():
                raise InputError(
                    "the compiled functions of this package do not match its C sources: "
                    "install the package again, with pip install --editable ."
                )
    return module
