"""Templates of pages, filled in."""

from __future__ import annotations

from importlib.resources import files
from typing import Any


def filled(package: str, name: str, **values: Any) -> str:
    """A template that lies in a package, filled in: HTML in UTF-8.

    What it names and is not given is an error, and values are escaped. It may include what
    pages share, which lies beside this module.
    """
    from jinja2 import Environment, FunctionLoader, StrictUndefined

    template = _text(package, name)
    environment = Environment(
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        loader=FunctionLoader(lambda shared: _text("firstcontact.report", shared)),
    )
    page = environment.from_string(template).render(**values)
    # A path on the command line need not be UTF-8; a page is.
    return page.encode("utf-8", "replace").decode("utf-8")


def _text(package: str, name: str) -> str:
    return files(package).joinpath(name).read_text(encoding="utf-8")
