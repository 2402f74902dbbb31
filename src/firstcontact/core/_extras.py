"""Optional packages (extras), and errors that name the command to install the packages."""

from __future__ import annotations

import json
import re
import shlex
import shutil
import sys
from collections.abc import Iterable
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path
from typing import Protocol
from urllib.parse import urlsplit
from urllib.request import url2pathname

from firstcontact.core._errors import InputError

_PACKAGE = "firstcontact"
#: Root of the clone that holds this file, unless the package is installed as a copy.
_CLONE = Path(__file__).parents[3]


class HasRequirements(Protocol):
    """Registered entry that may need packages beyond the base install."""

    @property
    def extra(self) -> str:
        """Extra of this package that the entry needs; "" if the base install suffices."""

    @property
    def modules(self) -> tuple[str, ...]:
        """Modules that the entry imports from the extra."""


def missing_modules(modules: Iterable[str]) -> list[str]:
    """Return the modules of this list that are not installed."""
    return [m for m in modules if find_spec(m) is None]


def require_modules(extra: str, *modules: str) -> None:
    """Raise an error with the install command if any of these modules is missing.

    Raises
    ------
    InputError
        A module is missing. The message holds the command that installs the extra.
    """
    missing = missing_modules(modules)
    if missing:
        raise InputError(
            f"this command or call needs {', '.join(missing)}, which is not installed: "
            f"{install_command(extra)}"
        )


def install_command(extra: str) -> str:
    """Return the command that installs an extra from the origin of this package.

    If this package was installed from a clone or a wheel that still exists, the command names its
    path. Otherwise it names the packages of the extra, because no package index holds this package.
    """
    pip = shutil.which("pip")
    environment_bin = Path(sys.executable).parent
    command = (
        ["pip"] if pip and Path(pip).parent == environment_bin else [sys.executable, "-m", "pip"]
    )
    if (_CLONE / "pyproject.toml").is_file():
        command += ["install", "-e", f"{_CLONE}[{extra}]"]
    elif (origin := _origin()) is not None:
        command += ["install", f"{origin}[{extra}]"]
    else:
        command += ["install", *_requirements(extra)]
    return shlex.join(command)


def _origin() -> Path | None:
    """Return the local clone or wheel that this package was installed from, if it still exists."""
    try:
        record = metadata.distribution(_PACKAGE).read_text("direct_url.json")
    except metadata.PackageNotFoundError:
        return None
    url = urlsplit(json.loads(record)["url"] if record else "")
    path = Path(url2pathname(url.path))
    return path if url.scheme == "file" and path.exists() else None


def _requirements(extra: str) -> list[str]:
    """Return the requirements of an extra and of the extras that it includes."""
    requirements = []
    for line in metadata.requires(_PACKAGE) or []:
        # "matplotlib>=3.9; extra == 'plot'" or "firstcontact[plot,cnn]; extra == 'study'"
        requirement, _, marker = line.partition(";")
        if not re.fullmatch(rf"""\s*extra\s*==\s*["']{extra}["']\s*""", marker):
            continue
        included = re.fullmatch(rf"{_PACKAGE}\[(.*)\]", requirement.strip())
        if included is None:
            requirements.append(requirement.strip())
        else:
            for name in included[1].split(","):
                requirements += _requirements(name.strip())
    return requirements


def require_extra(entry: HasRequirements) -> None:
    """Raise an error with the install command if a module that an entry needs is missing.

    Raises
    ------
    InputError
        A module is missing. The message holds the command that installs the extra.
    """
    require_modules(entry.extra, *entry.modules)
