"""Write the table of objects in docs/reference/twin-parameters.md from the twin's code."""

from __future__ import annotations

from pathlib import Path

from firstcontact.twin import BLOCKS
from firstcontact.twin.objects import EVERYDAY_OBJECTS, TwinObject
from firstcontact_lab.report.tables import fill, markdown_table

PAGE = Path(__file__).parent / "reference/twin-parameters.md"


def _mechanics(kind: TwinObject) -> list[str]:
    o = kind.nominal
    values = [
        kind.shore_a, o.modulus / 1e6, o.radius, o.face_mass, o.bulk_stiffness, o.bulk_damping,
        o.clamp_stiffness, o.clamp_damping, o.dent_stiffness, o.arm_share, o.slow_share,
        kind.modulus_scatter,
    ]  # fmt: skip
    return [kind.name, *("flat" if value == 1000 else f"{value:.3g}" for value in values)]


def filled(text: str) -> str:
    """Return the page with its table in place."""
    mechanics = (
        "object | Shore A | modulus, MPa | radius, m | face mass, kg | bulk stiffness, N/m | "
        "bulk damping, N s/m | clamp stiffness, N/m | clamp damping, N s/m | dent, N/m | "
        "fast arm | slow arm | scatter"
    )
    rows = map(_mechanics, (*BLOCKS, *EVERYDAY_OBJECTS))
    return fill(text, "objects", {"mechanics": markdown_table(mechanics, rows)})


if __name__ == "__main__":
    PAGE.write_text(filled(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
