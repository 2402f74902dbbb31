"""Estimators, one a file, and the saved-model format."""

from firstcontact.stiffness.card import Card, LearnedFrom, ModelCard
from firstcontact.stiffness.estimator import Estimator
from firstcontact.stiffness.interval import Interval
from firstcontact.stiffness.learned_from import pinch_digests
from firstcontact.stiffness.model import Model
from firstcontact.stiffness.model_file import (
    load_digests,
    load_interval,
    load_model,
    model_folders,
    read_card,
    save_model,
)
from firstcontact.stiffness.registry import ESTIMATORS, MODELS, make_estimator
from firstcontact.stiffness.spec import Spec, Task, usable

__all__ = [
    "ESTIMATORS",
    "MODELS",
    "Card",
    "Estimator",
    "Interval",
    "LearnedFrom",
    "Model",
    "ModelCard",
    "Spec",
    "Task",
    "load_digests",
    "load_interval",
    "load_model",
    "make_estimator",
    "model_folders",
    "pinch_digests",
    "read_card",
    "save_model",
    "usable",
]
