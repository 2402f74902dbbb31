"""Versions of the packages that results depend on."""

from __future__ import annotations

import platform
from functools import cache
from importlib.metadata import PackageNotFoundError, version

#: Packages whose versions a result depends on.
PACKAGES = (
    "firstcontact",
    "numpy",
    "scipy",
    "scikit-learn",
    "torch",
    "onnxruntime",
    "matplotlib",
)


def installed_versions() -> dict[str, str]:
    """Return the versions of Python and of the installed packages that results depend on."""
    return dict(_versions())


@cache  # reading a package's metadata takes milliseconds, and pages are rendered again and again
def _versions() -> dict[str, str]:
    versions = {"python": platform.python_version()}
    for package in PACKAGES:
        try:
            versions[package] = version(package)
        except PackageNotFoundError:
            continue
    return versions
