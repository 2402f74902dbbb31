"""Voltage of the piezo disc per newton on the pad, for two ways to hold the board.

*Bending*: the board's edges rest on a ledge over a hollow. The board bends, and stretches the disc
on its back. *Thickness*: the disc rests on a flat post. All of the force goes through the disc.
Navier's solution for a simply supported rectangular plate (Timoshenko and Woinowsky-Krieger,
Theory of Plates and Shells, 1959, ch. 5) gives the moments of the board. Over the disc, board and
disc bend together, which moves the neutral plane towards the disc. The moments are taken as those
of the board alone.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from dimensions import NOMINAL
from scipy.special import j1

#: Board, m.
LENGTH, WIDTH = NOMINAL.board_length * 1e-3, NOMINAL.board_width * 1e-3
THICKNESS = NOMINAL.board_thickness * 1e-3
#: Disc, m, and its capacitance, F (assumption).
RADIUS, DISC_THICKNESS = NOMINAL.disc_diameter / 2 * 1e-3, NOMINAL.disc_thickness * 1e-3
CAPACITANCE = 12e-9
#: PZT-5A, data sheets: d33 and d31 (absolute) in C/N, Young's modulus in Pa, Poisson's ratio.
D33, D31, PZT_MODULUS, PZT_POISSON = 390e-12, 175e-12, 61e9, 0.31


class Fr4(NamedTuple):
    """Elastic constants of FR4: 18 to 24 GPa in data sheets of laminates."""

    modulus: float = 22e9
    poisson: float = 0.14


NOMINAL = Fr4()


def pressed() -> float:
    """Return the open-circuit voltage per newton through the disc's thickness, V/N.

    Each newton through the disc gives the charge d33, wherever the force acts.
    """
    return D33 / CAPACITANCE


def bent(side: float | None = None, fr4: Fr4 = NOMINAL, terms: int = 99) -> float:
    """Return the open-circuit voltage per newton of the bent board, V/N.

    Parameters
    ----------
    side
        Side of a square in the middle of the board that is loaded evenly, m. None loads the whole
        board.
    fr4
        Elastic constants of the board.
    terms
        Largest order of the series.
    """
    orders = np.arange(1, terms + 1, 2)
    m, n = orders[:, None], orders[None, :]
    rigidity = fr4.modulus * THICKNESS**3 / (12 * (1 - fr4.poisson**2))
    a, b = (LENGTH, WIDTH) if side is None else (side, side)
    # Fourier coefficients of 1 N spread evenly over the a x b in the middle.
    signs = np.sin(m * math.pi / 2) * np.sin(n * math.pi / 2)
    load = 16 / (math.pi**2 * m * n * a * b) * signs
    load = load * np.sin(m * math.pi * a / (2 * LENGTH)) * np.sin(n * math.pi * b / (2 * WIDTH))
    curvature = load / (math.pi**2 * rigidity * ((m / LENGTH) ** 2 + (n / WIDTH) ** 2))
    # Mean over the disc of sin sin: J1(k R) 2 / (k R) times the value in the middle.
    k = math.pi * RADIUS * np.hypot(m / LENGTH, n / WIDTH)
    moment = rigidity * float((curvature * signs * 2 * j1(k) / k).sum())
    board = fr4.modulus / (1 - fr4.poisson**2) * THICKNESS
    disc = PZT_MODULUS / (1 - PZT_POISSON**2) * DISC_THICKNESS
    distance = (THICKNESS + DISC_THICKNESS) / 2
    shift = distance * disc / (board + disc)
    together = rigidity + board * shift**2 + disc * (distance - shift) ** 2
    strain = moment / together * (distance - shift)
    charge = D31 * PZT_MODULUS / (1 - PZT_POISSON) * strain * math.pi * RADIUS**2
    return charge / CAPACITANCE
