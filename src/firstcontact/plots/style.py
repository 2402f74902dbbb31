"""Style of plots: fonts, axes, and the names of objects and files in them.

Names from recordings are drawn as plain text, with the characters that the font has.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Any

from firstcontact.core.display import FAMILIAR

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: Settings for :func:`matplotlib.rc_context` that draw text literally, dollar signs included.
PLAIN: Any = {"text.parse_math": False, "text.usetex": False, "font.family": "DejaVu Sans"}
#: Longest name in a figure; longer ones are cut.
MOST = 28
#: Grey of what matters less.
QUIET = "#8a8f98"


def new_axes(figure: Figure) -> Axes:
    figure.set_size_inches(7.0, 3.6)
    axes = figure.subplots()
    axes.spines[["top", "right"]].set_visible(False)
    return axes


def name_hardness(axes: Axes) -> None:
    """Write familiar objects, such as a car tyre, beside a vertical axis in Shore A."""
    side = axes.secondary_yaxis("right")
    names, values, _ = zip(*FAMILIAR, strict=True)
    side.set_yticks(values, names)
    side.tick_params(colors=QUIET, labelsize=8)
    side.spines[["right"]].set_visible(False)


def figure_label(name: str, most: int = MOST) -> str:
    """Return a name from a recording for a figure, at most ``most`` characters.

    Characters that the font lacks become codes such as "U+2603".
    """
    glyphs = _font_code_points()
    out = ""
    for character in " ".join(name[: 4 * most].split()):
        is_drawable = ord(character) in glyphs and character.isprintable()
        out += character if is_drawable else f"U+{ord(character):04X}"
    return out if len(out) <= most and len(name) <= 4 * most else f"{out[: most - 1]}…"


@lru_cache(maxsize=1)
def _font_code_points() -> frozenset[int]:
    from matplotlib.font_manager import findfont, get_font

    return frozenset(get_font(findfont(PLAIN["font.family"])).get_charmap())
