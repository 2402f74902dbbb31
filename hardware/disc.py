"""Computed voltage of the piezo disc per newton on the pad, for several glues and discs.

The fingertip is a stack on the mount: floor, post, glue, disc, glue, board. The rectangle of the
board is replaced by a disc of the same area. Only the part of a load that is equal all round gives
charge, so a dimple is replaced by a ring. The pad does not bend the board: it presses through its
dimples.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

from dimensions import NOMINAL as D
from stack import VACUUM, Layer, Material, Stack, isotropic, piezoelectric

#: PZT-5A, from data sheets: free permittivity, and charge constant along the axis in C/N.
PERMITTIVITY, D33 = 1700, 374e-12
PZT = piezoelectric(
    16.4e-12, -5.74e-12, -7.22e-12, 18.8e-12, 47.5e-12, -171e-12, D33, 584e-12, 1730, PERMITTIVITY
)
#: FR4 along its faces: 18 to 24 GPa in data sheets of laminates.
FR4 = isotropic(22e9, 0.14)
PETG = isotropic(2e9, 0.4)
EPOXY = isotropic(3e9, 0.35)


def silicone(modulus: float = 1.3e6, poisson: float = 0.49) -> Material:
    """Return silicone as a material. 1.3 MPa is 33 Shore A by Gent's formula."""
    return isotropic(modulus, poisson)


SILICONE = silicone()
#: Folded foil between disc and land, as soft as its adhesive.
FOIL = silicone(10e6)


@dataclass(frozen=True)
class Gluing:
    """Disc and its two layers of glue. Lengths in m."""

    post_glue: Material = SILICONE
    board_glue: Material = SILICONE
    post_gap: float = D.post_glue * 1e-3
    """Thickness of the glue between disc and post."""
    board_gap: float = D.board_glue * 1e-3
    """Thickness of the glue between disc and board."""
    disc: float = D.disc_thickness * 1e-3
    """Thickness of the disc."""
    contact: Material = FOIL
    """Contact of disc and land within the glue."""
    contact_radius: float = math.sqrt(D.foils / math.pi) * D.foil_side * 1e-3
    """Radius of a spot in the middle with the area of all contacts."""
    mount: Material = PETG
    post_radius: float = D.disc_diameter * 0.5e-3

    def stack(self, size: float = 0.25e-3) -> Stack:
        """Return the finite elements of a fingertip that is glued this way.

        ``size`` is the largest length of an element, m.
        """
        board = math.sqrt(D.board_length * D.board_width / math.pi) * 1e-3
        disc = D.disc_diameter * 0.5e-3
        spot = self.contact_radius, self.contact
        return Stack([
            Layer(D.floor * 1e-3, board + D.wall * 1e-3, self.mount, 4),
            Layer(D.post_height * 1e-3, self.post_radius, self.mount, 4),
            Layer(self.post_gap, disc, self.post_glue),
            Layer(self.disc, disc, PZT),
            Layer(self.board_gap, disc, self.board_glue, spot=spot),
            Layer(D.board_thickness * 1e-3, board, FR4, 4),
        ], size)  # fmt: skip


@dataclass(frozen=True)
class Sensitivity:
    """Open-circuit voltage of the disc per newton, V/N, for three places of the load.

    ``capacitance`` is that of the disc in the stack, F.
    """

    centre: float
    middle: float
    """Load on a dimple of the middle row."""
    corner: float
    """Load on a dimple at a corner."""
    capacitance: float

    @property
    def all(self) -> float:
        """Voltage for a load on all six dimples, two in the middle row and four at corners, V/N."""
        return (self.middle + 2 * self.corner) / 3

    @property
    def spread(self) -> float:
        """Largest relative deviation of one place from the load on all dimples."""
        return max(abs(v / self.all - 1) for v in (self.centre, self.middle, self.corner))


@cache
def sensitivity(gluing: Gluing = Gluing()) -> Sensitivity:
    """Compute the voltages per newton and the capacitance for a way to glue the disc."""
    stack, half = gluing.stack(), D.dimple_diameter * 0.5e-3
    radii = sorted({round(1e-3 * math.hypot(*place), 9) for place in D.taxels})
    middle, corner = (stack.volts_per_newton(r - half, r + half) for r in radii)
    return Sensitivity(stack.volts_per_newton(0, half), middle, corner, stack.capacitance())


#: Capacitance of a free disc, F.
CAPACITANCE = (
    PERMITTIVITY * VACUUM * math.pi * (D.disc_diameter * 0.5e-3) ** 2 / (D.disc_thickness * 1e-3)
)
#: Gluings that are compared, by the words of the table of the page.
GLUINGS = {
    "**silicone on both faces**": Gluing(),
    "silicone, twice as stiff, layers 0.05 mm thinner": Gluing(
        silicone(2.6e6), silicone(2.6e6), 0.05e-3, 0.1e-3
    ),
    "silicone, half as stiff, layers 0.05 mm thicker": Gluing(
        silicone(0.65e6), silicone(0.65e6), 0.15e-3, 0.2e-3
    ),
    "a dot of silver epoxy, 3 mm across, in place of the foil": Gluing(contact=EPOXY),
    "silver silicone of 5 MPa at the board": Gluing(board_glue=silicone(5e6)),
    "conductive tape of 10 MPa, 0.05 mm, at the board": Gluing(
        board_glue=silicone(10e6), board_gap=0.05e-3
    ),
    "epoxy at the board, silicone at the post": Gluing(
        board_glue=EPOXY, board_gap=0.05e-3, contact=EPOXY
    ),
    "epoxy at the post, silicone at the board": Gluing(post_glue=EPOXY),
    "epoxy on both faces": Gluing(EPOXY, EPOXY, board_gap=0.05e-3, contact=EPOXY),
}
