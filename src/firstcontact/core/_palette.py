"""Colours for figures, distinct for colour-blind readers (Okabe and Ito 2008)."""

from __future__ import annotations

# https://jfly.uni-koeln.de/color/
BLUE, ORANGE, GREEN, RED = "#0072B2", "#E69F00", "#009E73", "#D55E00"
PURPLE, SKY, GREY, INK = "#CC79A7", "#56B4E9", "#8A94A0", "#1F2933"
