"""Show the roles of docstrings, such as ``:func:`detect```, as code on the site."""

from __future__ import annotations

import re
from typing import Any

import griffe

_ROLE = re.compile(r":\w+:`[~.]?(?P<name>[^`]*)`")


class Roles(griffe.Extension):
    """Extension of mkdocstrings that replaces each role by the name in it."""

    def on_object(self, *, obj: griffe.Object, **_: Any) -> None:
        """Replace the roles of one docstring."""
        if obj.docstring:
            obj.docstring.value = _ROLE.sub(r"``\g<name>``", obj.docstring.value)
