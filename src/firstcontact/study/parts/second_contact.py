"""Whether the second contact inside the window helps or hurts."""

from __future__ import annotations

from typing import Any

import numpy as np

from firstcontact.study.figures.second import second_figure
from firstcontact.study.metrics import regression_scores
from firstcontact.study.parts.blocks import SESSION
from firstcontact.study.parts.objects import UNSEEN
from firstcontact.study.settings import DURATION, Settings
from firstcontact.study.subject import Outcome, Subject


def second_contact(subject: Subject, settings: Settings) -> Outcome:
    """Errors of the predictions made so far, by where the second contact lies."""
    offsets = np.array([np.nan if p.offset is None else p.offset for p in subject.dataset.pinches])
    if not np.isfinite(offsets).any():
        return Outcome(left_out=["Second contact in the window: second contacts are not known."])
    tree: dict[str, Any] = {}
    for (model, split), (data, predicted) in subject.predictions.items():
        side = {SESSION: "blocks", UNSEEN: "objects"}.get(split)
        if side is None or model not in ("svm", "cnn"):
            continue
        offset = offsets[data.which]
        asked = np.isfinite(predicted) & np.isfinite(offset)
        clusters = data.clusters if side == "blocks" else data.specimens
        for name, its in (
            ("with", asked & (offset < DURATION)),
            ("without", asked & (offset >= DURATION)),
        ):
            if its.any():
                scores = regression_scores(
                    data.y[its], predicted[its], clusters[its], settings.seed
                )
                tree.setdefault(model, {}).setdefault(side, {})[name] = scores
    if not tree:
        return Outcome(
            left_out=["Second contact in the window: no split by session or of unseen objects."]
        )
    return Outcome({"second_contact_in_window": tree}, [second_figure(tree)])
