"""Commands, one file each: a dataclass of options with a method ``run``.

The file's name is the command's name: ``flash_model.py`` holds the class ``FlashModel`` of the
command ``flash-model``. Other packages add commands by entry points of the group
``firstcontact.verbs``. Importing this package imports no command.
"""

from __future__ import annotations

import re
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from pkgutil import iter_modules
from typing import Any

from firstcontact.core import ArgumentError, InputError
from firstcontact.core.text import summarize_error

#: Group of the entry points by which other packages register verbs.
GROUP = "firstcontact.verbs"


@cache
def verb_places() -> dict[str, str]:
    """Return the class of each command by the command's name, as text "module:Class"."""
    modules = sorted(module.name for module in iter_modules(__path__))
    places = {_verb(name): f"{__name__}.{name}:{_class(name)}" for name in modules}
    from importlib.metadata import entry_points  # 20 ms that a verb of ours need not wait for

    for point in sorted(entry_points(group=GROUP), key=lambda p: p.name):
        places.setdefault(point.name, point.value)
    return places


def configuration(verb: str) -> type[Any]:
    """Import and return the dataclass of a command. Raise InputError if this fails."""
    place = verb_places().get(verb)
    if place is None:
        raise ArgumentError(f"{verb!r} is not a command: choose one of {', '.join(verb_places())}")
    module, _, attribute = place.partition(":")
    try:
        imported: type[Any] = getattr(import_module(module), attribute)
    except Exception as error:
        if module.startswith(("firstcontact.", "firstcontact_lab.")):
            raise
        raise InputError(
            f"the command {verb!r} of another package cannot be imported "
            f"({summarize_error(error)}): update or remove that package"
        ) from error
    return imported


def summary(verb: str) -> str:
    """Return the first paragraph of a command's docstring, without importing the command."""
    module, _, attribute = verb_places()[verb].partition(":")
    try:
        spec = find_spec(module)
        text = "" if spec is None or spec.origin is None else Path(spec.origin).read_text("utf-8")
    except (ImportError, OSError, ValueError):
        return "(cannot be read: update or remove the package that brings it)"
    match = re.search(
        rf'^class {attribute}\b.*?:\n    """(.*?)(\n\n|""")', text, re.DOTALL | re.MULTILINE
    )
    return "" if match is None else " ".join(match[1].split())


def overview(width: int) -> str:
    """Return the text of ``firstcontact --help``, wrapped at ``width`` characters."""
    from textwrap import wrap

    import firstcontact

    indent = " " * (max(map(len, verb_places())) + 4)
    lines = [
        "usage: firstcontact [--verbose] COMMAND [OPTIONS]",
        "",
        firstcontact.__doc__ or "",
        "",
    ]
    for verb in verb_places():
        first, *more = wrap(summary(verb), max(width - len(indent), 20)) or [""]
        lines += [f"  {verb}".ljust(len(indent)) + first, *(indent + line for line in more)]
    lines += ["", "Options of a command: firstcontact COMMAND --help"]
    lines += ["Log of its steps on standard error: --verbose"]
    return "\n".join([*lines, "Version of firstcontact: firstcontact --version"])


def _verb(module: str) -> str:
    return module.rstrip("_").replace("_", "-")


def _class(module: str) -> str:
    return "".join(word.capitalize() for word in module.split("_"))
