"""Optional packages (extras): refusals that name the command to install them."""

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
#: The clone around this file, if it is not an installed copy.
_CLONE = Path(__file__).parents[3]


class Needing(Protocol):
    """A registered entry that may need more than the base install."""

    @property
    def extra(self) -> str:
        """Of this package; "" where the base install does."""

    @property
    def modules(self) -> tuple[str, ...]:
        """What the extra brings and the entry imports."""


def missing_modules(modules: Iterable[str]) -> list[str]:
    """Those of these modules that are not installed."""
    return [m for m in modules if find_spec(m) is None]


def require_modules(extra: str, *modules: str) -> None:
    """Refuse with the install command if any of these modules is missing.

    Raises
    ------
    InputError
        Names the extra to install.
    """
    missing = missing_modules(modules)
    if missing:
        raise InputError(
            f"this needs {', '.join(missing)}, which the base install leaves out: "
            f"{install_command(extra)}"
        )


def install_command(extra: str) -> str:
    """Return the command that installs an extra where this package came from.

    A clone or a wheel that is still there is named by its path. Otherwise the command names
    the packages of the extra, because this package is on no index.
    """
    pip = shutil.which("pip")
    here = Path(sys.executable).parent
    words = ["pip"] if pip and Path(pip).parent == here else [sys.executable, "-m", "pip"]
    if (_CLONE / "pyproject.toml").is_file():
        words += ["install", "-e", f"{_CLONE}[{extra}]"]
    elif (origin := _origin()) is not None:
        words += ["install", f"{origin}[{extra}]"]
    else:
        words += ["install", *_requirements(extra)]
    return shlex.join(words)


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
    """Return the requirements of an extra, those of the extras that it includes among them."""
    requirements = []
    for line in metadata.requires(_PACKAGE) or []:
        # "numba>=0.60; extra == 'twin'" or "firstcontact[twin,plot]; extra == 'study'"
        requirement, _, marker = line.partition(";")
        if not re.fullmatch(rf"""\s*extra\s*==\s*["']{extra}["']\s*""", marker):
            continue
        own = re.fullmatch(rf"{_PACKAGE}\[(.*)\]", requirement.strip())
        if own is None:
            requirements.append(requirement.strip())
        else:
            for name in own[1].split(","):
                requirements += _requirements(name.strip())
    return requirements


def require_extra(entry: Needing) -> None:
    """Refuse with the install command if what a registered entry needs is missing.

    Raises
    ------
    InputError
        Names the extra to install.
    """
    require_modules(entry.extra, *entry.modules)
