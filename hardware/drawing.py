"""Line drawings in SVG: projected solids, hatched sections, dimensions and labels.

``View`` holds the lines and areas of one projection, in mm. ``Drawing`` is the sheet.
:meth:`Drawing.place` puts a view on it and returns ``Placed``, which adds dimensions and labels at
points of the view.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from html import escape
from pathlib import Path

from build123d import Align, Box, Edge, GeomType, Part, Plane, Pos, Vector

#: Direction to the viewer and direction up, of each projection.
TOP = (0, 0, 1), (0, 1, 0)
BOTTOM = (0, 0, -1), (0, 1, 0)
SIDE = (0, -1, 0), (0, 0, 1)
ISOMETRIC = (-1.0, -1.2, 1.0), (0, 0, 1)
#: Fill of each material.
COLOURS = {
    "petg": "#cfd8e6",
    "pzt": "#e3c04c",
    "fr4": "#7fb58d",
    "velostat": "#4a4a4a",
    "silicone": "#f2c9b0",
    "glue": "#c98be0",
    "copper": "#d98f4e",
    "gold": "#f3e3b3",
    "paper": "#ffffff",
}
#: Material of each part of the assembled fingertip.
MATERIALS = {
    "mount": "petg", "disc": "pzt", "board": "fr4", "sheet": "velostat", "pad": "silicone",
}  # fmt: skip
_STYLE = """.v{fill:none;stroke:#1b2a41;stroke-width:1.4;stroke-linejoin:round;stroke-linecap:round}
.f{stroke:#1b2a41;stroke-width:.9;stroke-linejoin:round}
.c{fill:none;stroke:#8593a8;stroke-width:.9;stroke-dasharray:14 3 3 3}
.d{fill:none;stroke:#2f6fa8;stroke-width:.9}.a{fill:#2f6fa8}.n{fill:#2f6fa8}
.l{fill:none;stroke:#50627a;stroke-width:.9}.o{fill:#50627a}
text{font:13px sans-serif;fill:#1b2a41}.t{font-weight:bold}.s{fill:#50627a}
.n{stroke:#fff;stroke-width:4;stroke-linejoin:round;paint-order:stroke}"""
Point = tuple[float, float]
Line = list[Point]


def _points(edge: Edge, axes: str = "XY") -> Line:
    """Return points on an edge, at most 0.5 mm apart on a curve."""
    count = 1 if edge.geom_type == GeomType.LINE else 5 + int(2 * edge.length)
    return [
        (getattr(p, axes[0]), getattr(p, axes[1]))
        for p in (edge.position_at(i / count) for i in range(count + 1))
    ]


@dataclass
class View:
    """Lines and filled areas of a projection, in mm."""

    visible: list[Line] = field(default_factory=list)
    areas: list[tuple[str, list[Line]]] = field(default_factory=list)
    """Material and outlines of each filled face."""
    is_section: bool = False
    """True if the areas are cuts, which are hatched and lie over the lines."""
    opacity: float = 1.0


def project(part: Part, direction: tuple = TOP) -> View:
    """Return the visible lines of a part, seen along ``direction``."""
    eye, up = direction
    origin = Vector(*eye).normalized() * 1000
    visible, _ = part.project_to_viewport(origin, up, look_at=(0, 0, 0))
    return View([_points(edge) for edge in visible])


def seen(point: tuple[float, float, float], direction: tuple = ISOMETRIC) -> Point:
    """Return the point at which a projection shows a point in space, mm."""
    eye, up = (Vector(*v).normalized() for v in direction)
    right = up.cross(eye).normalized()
    return Vector(*point).dot(right), Vector(*point).dot(eye.cross(right))


def pictured(part: Part, material: str, direction: tuple = ISOMETRIC) -> View:
    """Return the projection of a part with its outline, filled as this material."""
    view = project(part, direction)
    corners, triangles = part.tessellate(0.1, 0.5)
    flat = [seen(tuple(p), direction) for p in corners]
    front = []
    for i, j, k in triangles:
        (x0, y0), (x1, y1), (x2, y2) = flat[i], flat[j], flat[k]
        if (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0) > 1e-9:
            front.append([flat[i], flat[j], flat[k]])
    view.areas = [(material, front)]
    return view


def section(parts: Iterable[tuple[str, Part, float]]) -> View:
    """Return the cut through parts, seen along +y, and the visible lines behind it.

    Each part comes with its material and with the y at which it is cut, mm.
    """
    view = View(is_section=True)
    for material, part, y in parts:
        beyond = Pos(0, y, 0) * Box(500, 500, 500, align=(Align.CENTER, Align.MIN, Align.CENTER))
        view.visible += project(part & beyond, SIDE).visible
        for face in (part & Plane.XZ.offset(-y)).faces():
            outlines = []
            for wire in [face.outer_wire(), *face.inner_wires()]:
                outlines.append([p for edge in wire.order_edges() for p in _points(edge, "XZ")])
            view.areas.append((material, outlines))
    return view


class Drawing:
    """SVG sheet on which views are placed. Lengths are in pixels."""

    def __init__(self, width: int, height: int, title: str) -> None:
        self.size = width, height
        self.title = title
        self.items: list[str] = []

    def text(
        self, x: float, y: float, words: str, kind: str = "", anchor: str = "start",
        turned: bool = False,
    ) -> None:  # fmt: skip
        """Add a text at a pixel. With ``turned`` it reads upwards."""
        mark = f' class="{kind}"' if kind else ""
        mark += f' text-anchor="{anchor}"' if anchor != "start" else ""
        mark += f' transform="rotate(-90 {x:.1f} {y:.1f})"' if turned else ""
        self.items.append(f'<text x="{x:.1f}" y="{y:.1f}"{mark}>{escape(words)}</text>')

    def line(self, points: Line, kind: str) -> None:
        """Add a line through points."""
        steps = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
        self.items.append(f'<polyline class="{kind}" points="{steps}"/>')

    def arrow(self, tip: Point, angle: float, kind: str = "a") -> None:
        """Add an arrowhead at ``tip`` that points along ``angle``."""
        sides = (tip, *(
            (tip[0] - 8 * math.cos(angle + turn), tip[1] - 8 * math.sin(angle + turn))
            for turn in (-0.2, 0.2)
        ))  # fmt: skip
        steps = " ".join(f"{x:.1f},{y:.1f}" for x, y in sides)
        self.items.append(f'<polygon class="{kind}" points="{steps}"/>')

    def place(self, view: View, x: float, y: float, scale: float) -> Placed:
        """Draw a view with its origin at the pixel (x, y), at ``scale`` pixels per mm.

        Return it.
        """
        placed = Placed(self, x, y, scale)

        def path(lines: list[Line], end: str = "") -> str:
            return "".join(
                "M" + "L".join("{:.1f},{:.1f}".format(*placed.at(p)) for p in points) + end
                for points in lines
            )

        lines = f'<path class="{"l" if view.is_section else "v"}" d="{path(view.visible)}"/>'
        areas = []
        for material, outlines in view.areas:
            if view.is_section:
                look = f'class="f" fill="url(#{material})" fill-rule="evenodd"'
                look += f' fill-opacity="{view.opacity:g}"' if view.opacity < 1 else ""
            else:
                look = 'fill="{0}" stroke="{0}"'.format(COLOURS[material])
            areas.append(f'<path {look} d="{path(outlines, "Z")}"/>')
        self.items += [lines, *areas] if view.is_section else [*areas, lines]
        return placed

    def write(self, path: Path) -> None:
        """Write the sheet as an SVG file."""
        width, height = self.size
        hatched = "".join(
            f'<pattern id="{name}" width="7" height="7" patternUnits="userSpaceOnUse" '
            f'patternTransform="rotate(45)"><rect width="7" height="7" fill="{colour}"/>'
            + ('<path d="M0,0V7" stroke="#5b6c86" stroke-width="1.4"/>' if name == "petg" else "")
            + "</pattern>"
            for name, colour in COLOURS.items()
        )
        lines = [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
            f'width="{width}" height="{height}" role="img" aria-label="{escape(self.title)}">',
            f"<title>{escape(self.title)}</title>",
            f"<style>{_STYLE}</style><defs>{hatched}</defs>",
            f'<rect fill="#fff" width="{width}" height="{height}"/>',
            *self.items,
            "</svg>",
        ]
        path.write_text("\n".join(lines) + "\n", "utf-8")


@dataclass
class Placed:
    """View that was placed on a sheet. Points are in mm of the view."""

    drawing: Drawing
    x: float
    y: float
    scale: float

    def at(self, point: Point) -> Point:
        """Return the pixel of a point of the view."""
        return self.x + point[0] * self.scale, self.y - point[1] * self.scale

    def centre(self, middle: Point, across: float, up: float) -> None:
        """Add a cross of centre lines at ``middle``; ``across`` and ``up`` are half lengths, mm."""
        x, y = middle
        for dx, dy in ((across, 0), (0, up)):
            self.drawing.line([self.at((x - dx, y - dy)), self.at((x + dx, y + dy))], "c")

    def width(self, x0: float, x1: float, y: float, line: float, words: str = "") -> None:
        """Dimension the length from ``x0`` to ``x1``, at height ``y``.

        The dimension line lies at height ``line``, mm. ``words`` replace the number.
        """
        (a, start), (b, end) = self.at((x0, y)), self.at((x1, line))
        away = math.copysign(4, end - start)
        for x in (a, b):
            self.drawing.line([(x, start + away), (x, end + away)], "d")
        self._dimension((a, end), (b, end), words or f"{x1 - x0:g}")

    def height(self, y0: float, y1: float, x: float, line: float, words: str = "") -> None:
        """Dimension the height from ``y0`` to ``y1``, at the place ``x``.

        The dimension line lies at ``line``, mm. ``words`` replace the number.
        """
        (start, a), (end, b) = self.at((x, y0)), self.at((line, y1))
        away = math.copysign(4, end - start)
        for y in (a, b):
            self.drawing.line([(start + away, y), (end + away, y)], "d")
        self._dimension((end, a), (end, b), words or f"{y1 - y0:g}")

    def _dimension(self, a: Point, b: Point, words: str) -> None:
        """Add a dimension line from pixel ``a`` to ``b``.

        If it is short, its arrows lie outside.
        """
        angle = math.atan2(b[1] - a[1], b[0] - a[0])
        length = math.dist(a, b)
        outside = length < 20
        reach = 14 if outside else 0
        dx, dy = math.cos(angle), math.sin(angle)
        ends = [(a[0] - reach * dx, a[1] - reach * dy), (b[0] + reach * dx, b[1] + reach * dy)]
        self.drawing.line(ends, "d")
        self.drawing.arrow(a, angle if outside else angle + math.pi)
        self.drawing.arrow(b, angle + math.pi if outside else angle)
        x, y = (a[0] + b[0]) / 2, (a[1] + b[1]) / 2
        fits = length > 7.5 * len(words) + 8
        if abs(dy) > 0.5 and fits:
            self.drawing.text(x - 4, y, words, "n", "middle", turned=True)
        elif abs(dy) > 0.5:
            self.drawing.text(x + 5, y + 4, words, "n")
        elif fits:
            self.drawing.text(x, y - 4, words, "n", "middle")
        else:
            self.drawing.text(max(a[0], b[0]) + 17, y + 4, words, "n")

    def labels(self, x: float, y: float, labels: list[tuple[Point, str]], step: float = 26) -> None:
        """Add labels in a column that begins at a pixel of the sheet.

        A line leads from each label to its point. ``step`` is the distance of labels, pixels.
        """
        for point, words in labels:
            px, py = self.at(point)
            self.label(point, words, x - px, y - py)
            y += step * (1 + words.count("\n") * 0.6)

    def label(self, point: Point, words: str, dx: float, dy: float) -> None:
        """Add a label with a line to a point of the view.

        It is ``dx`` and ``dy`` pixels (down is positive) away from the point.
        """
        x, y = self.at(point)
        side = math.copysign(1, dx)
        self.drawing.line([(x, y), (x + dx, y + dy), (x + dx + 10 * side, y + dy)], "l")
        self.drawing.items.append(f'<circle class="o" cx="{x:.1f}" cy="{y:.1f}" r="2"/>')
        for i, part in enumerate(words.split("\n")):
            anchor = "start" if side > 0 else "end"
            self.drawing.text(x + dx + 14 * side, y + dy + 4 + 16 * i, part, "", anchor)
