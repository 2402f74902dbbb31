"""``--to c``: an Arduino and PlatformIO library in C99 with an example that counts its cycles."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

from firstcontact import __version__
from firstcontact.core import InputError
from firstcontact.export.c_code import write_chain, write_model
from firstcontact.export.parts import ModelExporter, Trained

_PROPERTIES = """\
name=FirstContactModel
version={version}
author=firstcontact
maintainer=firstcontact
sentence=Contact and stiffness on the hand's microcontroller.
paragraph=Written by firstcontact export-model: {parts}.
category=Sensors
architectures=*
includes={includes}
"""


def write(trained: Trained, out: Path) -> list[str]:
    """Write the library into an empty folder. Return notes for the user."""
    units = [write_model(named) for named in trained.models]
    if trained.has_chain:
        units.append(write_chain(trained))
    if not units:
        raise InputError("the model has no part that can be written in C: train an SVM")
    source, example = out / "src", out / "examples" / "cycles"
    source.mkdir()
    example.mkdir(parents=True)
    own, chain = (files(f"firstcontact.{room}") / "c" for room in ("export", "chain"))
    fixed = ["fc_flash.h", *["fc_svm.c", "fc_svm.h"] * bool(trained.models)]
    shared = "fc_" if trained.has_chain else "fc_math."
    entries = [own / name for name in fixed]
    entries += [entry for entry in chain.iterdir() if entry.name.startswith(shared)]
    for entry in entries:
        (source / entry.name).write_text(entry.read_text(encoding="utf-8"), encoding="utf-8")
    for unit in units:
        (source / f"{unit.name}.h").write_text(unit.header, encoding="utf-8")
        (source / f"{unit.name}.c").write_text(unit.source, encoding="utf-8")
    headers = [f"{unit.name}.h" for unit in units]
    properties = _PROPERTIES.format(
        version=__version__, parts="; ".join(trained.parts), includes=",".join(headers)
    )
    (out / "library.properties").write_text(properties, encoding="utf-8")
    calls = [
        f'  run_model<FC_{m.name.upper()}_SAMPLES * FC_{m.name.upper()}_CHANNELS>("fc_{m.name}", '
        f"fc_{m.name});"
        for m in trained.models
    ] + ["  run_chain();"] * trained.has_chain
    sketch = (own / "cycles.ino").read_text(encoding="utf-8")
    includes = "\n".join(f"#include <{header}>" for header in headers)
    sketch = sketch.replace("@INCLUDES@", includes).replace("@CALLS@", "\n".join(calls))
    (example / "cycles.ino").write_text(sketch, encoding="utf-8")
    return [unit.summary for unit in units]


C = ModelExporter("c", write)
