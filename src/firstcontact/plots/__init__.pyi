"""Plots of pinches, datasets, predictions and evaluations."""

from .notebook import notebook_html as notebook_html
from .predictions import draw_evaluation as draw_evaluation
from .predictions import draw_predictions as draw_predictions
from .recordings import draw_dataset as draw_dataset
from .recordings import draw_pinch as draw_pinch
from .recordings import plot_pinch as plot_pinch
