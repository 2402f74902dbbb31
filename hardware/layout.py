"""Plain data on the layout of a board: positions of parts, and stops of tracks.

Positions are in mm from the upper left corner of the board for the amplifier, and from the middle
for the fingertip; y points down, as in KiCad.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum

FRONT, BACK = "F.Cu", "B.Cu"
#: Revision of both boards.
REVISION = "B"
#: Smallest values on both boards, mm. They cost nothing extra at the usual board houses.
TRACK, CLEARANCE, DRILL, VIA = 0.2, 0.2, 0.3, 0.6

Point = tuple[float, float]


class Step(Enum):
    """Stop of a track that has no position of its own."""

    VIA = "a via, after which the track runs on the other side"


#: Place on a track: a pad such as ``R1.2``, a point, a point with one coordinate kept, or a via.
Stop = str | tuple[float | None, float | None] | Step


@dataclass(frozen=True)
class Track:
    """Track through a list of stops. Its net is that of the pads on it."""

    stops: tuple[Stop, ...]
    side: str = FRONT
    width: float = 0.25
    net: str = ""
    """Net of a track that touches no pad."""


@dataclass(frozen=True)
class Text:
    """Line of text on the silkscreen."""

    words: str
    at: Point
    height: float = 1.0
    degrees: float = 0.0
    side: str = FRONT
    align: int = 0
    """-1 for text that begins at its place, 0 for centred, 1 for text that ends there."""


@dataclass(frozen=True)
class Layout:
    """Layout of a board: positions, tracks and texts. Its nets are in ``circuit.py``."""

    name: str
    title: str
    corner: Point
    """Upper left corner."""
    size: Point
    places: Mapping[str, tuple[float, float, float]]
    """Position and angle of each part by reference, in degrees anticlockwise."""
    tracks: tuple[Track, ...]
    grounded: tuple[str, ...]
    """Sides that are filled with ground."""
    holes: tuple[Point, ...] = ()
    texts: tuple[Text, ...] = ()
    vias: tuple[Point, ...] = ()
    """Vias of the ground beside pads."""
    stitching: float = 0.0
    """Pitch of further vias of the ground, wherever there is space. 0 for none."""
    names: dict[str, Point] = field(default_factory=dict)
    """Places of the names of parts on the silkscreen, relative to the part. Others have none."""


def octilinear(points: Sequence[Point], chamfer: float = 0.8) -> list[Point]:
    """Return the points of a track through ``points``, in segments at multiples of 45 degrees.

    A segment in another direction ends with its diagonal part. Right angles are cut by ``chamfer``
    mm.
    """
    bent: list[Point] = [points[0]]
    for x, y in points[1:]:
        (x0, y0), diagonal = bent[-1], min(abs(x - bent[-1][0]), abs(y - bent[-1][1]))
        sx, sy = (1 if x > x0 else -1), (1 if y > y0 else -1)
        if diagonal > 1e-6 and abs(abs(x - x0) - abs(y - y0)) > 1e-6:
            bent.append((x - sx * diagonal, y - sy * diagonal))
        bent.append((x, y))
    cut: list[Point] = [bent[0]]
    for before, at, after in zip(bent, bent[1:], bent[2:], strict=False):
        (ax, ay), (bx, by) = (
            ((q[0] - at[0]), (q[1] - at[1])) for q in (before, after)
        )  # fmt: skip
        long_a, long_b = max(abs(ax), abs(ay)), max(abs(bx), abs(by))
        if min(long_a, long_b) > 1e-6 and ax * bx + ay * by == 0 and (ax == 0 or ay == 0):
            c = min(chamfer, long_a / 2, long_b / 2)
            cut += [
                (at[0] + c * x / n, at[1] + c * y / n)
                for x, y, n in ((ax, ay, long_a), (bx, by, long_b))
            ]
        else:
            cut.append(at)
    return [*cut, bent[-1]]
