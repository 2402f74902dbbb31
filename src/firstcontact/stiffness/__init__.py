"""Estimators, one a file, and the saved-model format."""

from __future__ import annotations

from typing import TYPE_CHECKING

from firstcontact.core.lazy import lazily

if TYPE_CHECKING:
    from firstcontact.stiffness.card import LearnedFrom, ModelCard, Provenance
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
    from firstcontact.stiffness.registry import ESTIMATORS, make_estimator
    from firstcontact.stiffness.spec import Spec, Task, usable
else:
    __getattr__ = lazily(
        __name__,
        {
            "card": "Provenance LearnedFrom ModelCard",
            "estimator": "Estimator",
            "interval": "Interval",
            "learned_from": "pinch_digests",
            "model": "Model",
            "model_file": (
                "load_digests load_interval load_model model_folders read_card save_model"
            ),
            "registry": "ESTIMATORS make_estimator",
            "spec": "Spec Task usable",
        },
    )

__all__ = [
    "ESTIMATORS",
    "Estimator",
    "Interval",
    "LearnedFrom",
    "Model",
    "ModelCard",
    "Provenance",
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
