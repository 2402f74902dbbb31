"""Templates of pages, filled in."""

from __future__ import annotations

from importlib.resources import files
from typing import Any

from firstcontact.core import sanitize


def filled(package: str, name: str, **values: Any) -> str:
    r"""Return a template of a package filled in: HTML in UTF-8.

    A name without a value is an error, and values are escaped. Control characters come out as
    ``\u001b``. The template may include files that pages share, which lie beside this module.
    """
    from jinja2 import Environment, FunctionLoader, StrictUndefined

    template = _text(package, name)
    environment = Environment(
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        loader=FunctionLoader(lambda shared: _text("firstcontact_lab.report", shared)),
    )
    # Names of files, recordings and plug-ins need be neither UTF-8 nor free of escapes.
    return sanitize(environment.from_string(template).render(**values))


def _text(package: str, name: str) -> str:
    return files(package).joinpath(name).read_text(encoding="utf-8")
