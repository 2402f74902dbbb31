"""Plots of pinches, datasets, predictions and evaluations."""

from .notebook import notebook_html as notebook_html
from .recordings import plot_pinch as plot_pinch
