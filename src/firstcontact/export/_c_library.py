"""``--to c``: an Arduino and PlatformIO library in C99 with an example that counts its cycles."""

from __future__ import annotations

from collections.abc import Collection
from importlib.resources import files
from pathlib import Path

from firstcontact import __version__
from firstcontact.core import InputError
from firstcontact.export._c_chain import write_chain
from firstcontact.export._c_model import write_model
from firstcontact.export._c_text import CUnit
from firstcontact.export._exporters import ModelExporter
from firstcontact.export._sketch import sketch
from firstcontact.export._trained import Trained

#: Name of the library in #include lines.
NAME = "FirstContactModel"

_PROPERTIES = """\
name={name}
version={version}
author=firstcontact
maintainer=firstcontact
sentence=Contact and stiffness on the hand's microcontroller.
paragraph=Written by firstcontact export-model: {parts}.
category=Sensors
architectures=*
includes={includes}
"""


#: Headers that other files include.
_SHARED = ("fc_math", "fc_flash")


def fixed_sources(names: Collection[str], *, with_chain: bool = False) -> dict[str, str]:
    """Return the hand-written C files with these names, given without ``.c`` and ``.h``.

    ``with_chain`` adds all files of the chain.
    """
    chain = files("firstcontact.chain") / "c"
    entries = [*(files("firstcontact.export") / "c").iterdir(), *chain.iterdir()]
    wanted = {*names, *_SHARED}
    if with_chain:
        wanted |= {e.name.rpartition(".")[0] for e in chain.iterdir() if e.name.startswith("fc_")}
    return {
        entry.name: entry.read_text(encoding="utf-8")
        for entry in sorted(entries, key=lambda e: e.name)
        if entry.name.rpartition(".")[0] in wanted
    }


def generate_units(trained: Trained) -> list[CUnit]:
    """Return the generated C units of a model."""
    units = [write_model(named) for named in trained.models]
    if trained.has_chain:
        units.append(write_chain(trained))
    return units


def write(trained: Trained, out: Path) -> list[str]:
    """Write the library into an empty folder. Return notes for the user."""
    units = generate_units(trained)
    if not units:
        raise InputError(
            f"no part of this model can be written in C (its parts: {', '.join(trained.parts)}): "
            "train another estimator or detector"
        )
    source, example = out / "src", out / "examples" / "cycles"
    source.mkdir()
    example.mkdir(parents=True)
    fixed = {name for unit in units for name in unit.fixed}
    for name, text in fixed_sources(fixed, with_chain=trained.has_chain).items():
        (source / name).write_text(text, encoding="utf-8")
    for unit in units:
        (source / f"{unit.name}.h").write_text(unit.header, encoding="utf-8")
        if unit.source:
            (source / f"{unit.name}.c").write_text(unit.source, encoding="utf-8")
    includes = [f"{unit.name}.h" for unit in units]
    properties = _PROPERTIES.format(
        name=NAME, version=__version__, parts="; ".join(trained.parts), includes=",".join(includes)
    )
    (out / "library.properties").write_text(properties, encoding="utf-8")
    (example / "cycles.ino").write_text(sketch(trained), encoding="utf-8")
    return [_unit_summary(unit) for unit in units]


def _unit_summary(unit: CUnit) -> str:
    took = f", about {unit.instructions} instructions" * bool(unit.instructions)
    at = f", for {unit.rate:g} Hz" if unit.rate else ""
    return f"{unit.name}: {unit.constants} bytes of constants, {unit.memory} of memory{took}{at}"


C = ModelExporter("c", write)
