"""Estimators, one a file, and the saved-model format."""

from firstcontact.stiffness.estimator import Estimator, Model, Spec, Task, usable
from firstcontact.stiffness.interval import Interval
from firstcontact.stiffness.model_file import (
    Card,
    load_interval,
    load_model,
    model_folders,
    read_card,
    save_model,
)
from firstcontact.stiffness.registry import ESTIMATORS, MODELS, make_estimator

__all__ = [
    "ESTIMATORS",
    "MODELS",
    "Card",
    "Estimator",
    "Interval",
    "Model",
    "Spec",
    "Task",
    "load_interval",
    "load_model",
    "make_estimator",
    "model_folders",
    "read_card",
    "save_model",
    "usable",
]
