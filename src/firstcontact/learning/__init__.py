"""Learning and being asked: splits, trainings, scores, and models that are kept."""

from __future__ import annotations

from typing import TYPE_CHECKING

from firstcontact.core.lazy import lazily

if TYPE_CHECKING:
    from firstcontact.learning.detection import DetectionScores, score_detector
    from firstcontact.learning.final_model import FinalModel, train_final_model
    from firstcontact.learning.metrics import classification_scores, regression_scores
    from firstcontact.learning.splits import Split, by_session, leave_one_out
    from firstcontact.learning.training import LabelledWindows, labelled_windows
else:
    __getattr__ = lazily(
        __name__,
        {
            "detection": "DetectionScores score_detector",
            "final_model": "FinalModel train_final_model",
            "metrics": "classification_scores regression_scores",
            "splits": "Split by_session leave_one_out",
            "training": "LabelledWindows labelled_windows",
        },
    )

__all__ = [
    "DetectionScores",
    "FinalModel",
    "LabelledWindows",
    "Split",
    "by_session",
    "classification_scores",
    "labelled_windows",
    "leave_one_out",
    "regression_scores",
    "score_detector",
    "train_final_model",
]
