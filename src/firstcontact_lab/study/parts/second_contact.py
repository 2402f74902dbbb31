"""Whether the second contact inside the window helps or hurts."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from firstcontact.models import DURATION, RegressionScores, Values, outcome, regression_scores
from firstcontact.signal import Conditioner, samples_in
from firstcontact_lab.report import names
from firstcontact_lab.report.figures.second import second_figure
from firstcontact_lab.report.findings import PartResult
from firstcontact_lab.report.results.stiffness import SecondContact
from firstcontact_lab.report.results.study import SubjectResults
from firstcontact_lab.study._subject import Subject
from firstcontact_lab.study.parts.blocks import SESSION
from firstcontact_lab.study.parts.objects import UNSEEN
from firstcontact_lab.study.settings import StudySettings


def second_contact(subject: Subject, settings: StudySettings) -> PartResult:
    """Errors of the predictions made so far, by where the second contact lies.

    A window that begins elsewhere than at the first contact (a false trigger, another
    finger's, a late one) says nothing of this: such windows are scored by themselves.
    """
    room = samples_to_spare(subject)
    astray = misplaced(subject, settings.early)
    if not np.isfinite(room).any():
        return PartResult(left_out=["Second contact in the window: second contacts are not known."])
    found: dict[str, dict[str, dict[str, RegressionScores]]] = {}
    for (model, split), (data, predicted) in subject.predictions.items():
        side = {SESSION: "blocks", UNSEEN: "objects"}.get(split)
        if side is None or names.is_floor(model):
            continue
        after = room[data.which]
        asked = np.isfinite(predicted) & np.isfinite(after)
        clusters = data.clusters if side == "blocks" else data.specimens
        wrong = astray[data.which]
        for name, its in (
            ("with", asked & ~wrong & (after < 0)),
            ("without", asked & ~wrong & (after >= 0)),
            ("misplaced", asked & wrong),
        ):
            if its.any():
                scores = regression_scores(
                    data.y[its], predicted[its], clusters[its], settings.seed
                )
                found.setdefault(model, {}).setdefault(side, {})[name] = scores
    if not found:
        return PartResult(
            left_out=["Second contact in the window: no split by session or of unseen objects."]
        )
    sides = {model: SecondContact(**its) for model, its in found.items()}
    return PartResult(SubjectResults(second_contact_in_window=sides), [second_figure(sides)])


def misplaced(subject: Subject, early: float) -> NDArray[np.bool_]:
    """Pinches whose window does not begin at their first contact, shape (pinches,)."""
    pairs = zip(subject.dataset.pinches, subject.starts, strict=True)
    return np.array(
        [
            pinch.first is not None
            and outcome(start, pinch.first, pinch.layout.rate, early) != "success"
            for pinch, start in pairs
        ],
        dtype=np.bool_,
    )


def samples_to_spare(subject: Subject) -> Values:
    """Samples from the end of each pinch's window to its second contact, shape (pinches,).

    Negative: the second contact is in the window, or came before it. NaN where
    it is not known or there is no window. A window begins where its contact was
    found, which is not quite where the first contact was.
    """
    out = np.full(len(subject.dataset), np.nan)
    for i, (pinch, start) in enumerate(zip(subject.dataset.pinches, subject.starts, strict=True)):
        if pinch.second is not None and start is not None:
            # The filter has looked at the samples just beyond the window, too.
            ahead = Conditioner(pinch.layout).lookahead
            end = start.sample + samples_in(DURATION, pinch.layout.rate) + ahead
            out[i] = pinch.second.sample - end
    return out
