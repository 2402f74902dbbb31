"""Write the tables of docs/reference/twin-parameters.md from the twin's code and its docstrings."""

from __future__ import annotations

import ast
import inspect
import re
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

from write_live import plain

from firstcontact.core import physics
from firstcontact.twin import (
    BLOCKS,
    CONDITIONS,
    _run,
    _stream,
    draw,
    mechanics,
    noise,
    objects,
    outcome,
    pinch,
    plant,
    sensor,
    simulation,
)
from firstcontact.twin.draw import Condition, Spread
from firstcontact.twin.drive import Drive
from firstcontact.twin.objects import EVERYDAY_OBJECTS, TwinObject
from firstcontact.twin.slip_sound import SlipParameters
from firstcontact_lab.report.tables import fill, markdown_table

PAGE = Path(__file__).parent / "reference/twin-parameters.md"
RECORDS: tuple[type[Any], ...] = (
    mechanics.FingerParameters, mechanics.ObjectParameters, noise.MotorNoise,
    mechanics.VelostatParameters, SlipParameters, Drive,
)  # fmt: skip
#: Constants of each table: a module, and names of its constants.
CONSTANTS: dict[str, tuple[tuple[ModuleType, str], ...]] = {
    "pinches": (
        (draw, "OFFSET_MEAN OFFSET_SD OFFSET_MAX FIRST_CONTACT CONDUCTANCE EXPONENT"),
        (draw, "LOADING_SCATTER"),
        (pinch, "DURATION BURN_IN"),
        (_run, "SUBSTEPS"),
        (noise, "OVERSAMPLING"),
        (sensor, "FORCE_READINGS"),
        (physics, "POISSON"),
        (simulation, "BLOCK_SESSIONS OBJECT_SESSIONS"),
    ),
    "running": ((_stream, "REST RAMP LEAD STALLED PATIENCE GRIP HOLD APART SETTLE"),),
    "held": (
        (objects, "FRICTION SKIN_FRICTION"),
        (physics, "GRAVITY"),
        (outcome, "LIFT"),
        (plant, "WATCHED LONGEST"),
        (outcome, "DROPPED SAFETY SMOOTHED STEADY"),
        (_run, "CALM"),
        (objects, "CRUSHED"),
    ),
}


def _mechanics(kind: TwinObject) -> list[str]:
    o = kind.nominal
    values = [
        kind.shore_a, o.modulus / 1e6, o.radius, o.face_mass, o.bulk_stiffness, o.bulk_damping,
        o.clamp_stiffness, o.clamp_damping, o.dent_stiffness, o.arm_share, o.slow_share,
        kind.modulus_scatter,
    ]  # fmt: skip
    return [kind.name, *("flat" if value == 1000 else f"{value:.3g}" for value in values)]


def field_texts(record: type[Any]) -> dict[str, str]:
    """Return the docstring of each field of a record, by name."""
    (body,) = ast.parse(inspect.getsource(record)).body
    assert isinstance(body, ast.ClassDef)
    texts = {}
    for field, text in zip(body.body, body.body[1:], strict=False):
        match field, text:
            case ast.AnnAssign(target=ast.Name(id=name)), ast.Expr(ast.Constant(value=str(doc))):
                texts[name] = plain(doc)
    return texts


def constant_text(module: ModuleType, name: str) -> str:
    """Return the comment before a constant, ``#: ...``."""
    found = re.search(rf"((?:^#: .*\n)+){name}\b.* = ", inspect.getsource(module), re.MULTILINE)
    if found is None:
        raise SystemExit(f"{module.__name__}.{name}: write a comment '#:' before it")
    return plain(found[1].replace("#: ", ""))


def _value(value: object) -> str:
    match value:
        case Spread():
            return f"{value.session:g} / {value.pinch:g}"
        case tuple():
            return ", ".join(f"{v:g}" for v in value)
    return f"{value:g}"


def _constants(names: tuple[tuple[ModuleType, str], ...]) -> Iterator[list[str]]:
    for module, listed in names:
        for name in listed.split():
            yield [f"`{name}`", _value(getattr(module, name)), constant_text(module, name)]


def filled(text: str) -> str:
    """Return the page with its tables in place."""
    objects_head = (
        "object | Shore A | modulus, MPa | radius, m | face mass, kg | bulk stiffness, N/m | "
        "bulk damping, N s/m | clamp stiffness, N/m | clamp damping, N s/m | dent, N/m | "
        "fast arm | slow arm | scatter"
    )
    made = {"objects": markdown_table(objects_head, map(_mechanics, (*BLOCKS, *EVERYDAY_OBJECTS)))}
    for record in RECORDS:
        rows = [[f"`{n}`", _value(getattr(record(), n)), t] for n, t in field_texts(record).items()]
        made[record.__name__] = markdown_table("field | value | meaning, and source", rows)
    conditions = [
        [f"`{n}`", *(_value(getattr(c, n)) for c in CONDITIONS.values()), t]
        for n, t in field_texts(Condition).items()
    ]
    head = f"field | {' | '.join(CONDITIONS)} | what varies, and why"
    made["conditions"] = markdown_table(head, conditions)
    for name, names in CONSTANTS.items():
        made[name] = markdown_table("constant | value | meaning, and source", _constants(names))
    return fill(text, "twin", made)


if __name__ == "__main__":
    PAGE.write_text(filled(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
