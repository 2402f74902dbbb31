"""``firstcontact evaluate`` of an any-time model: a table by the time after the contact."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from firstcontact.cli.verbs.train import aligned_by_truth, at_rate
from firstcontact.core import InputError, counted, percent, same_rate

if TYPE_CHECKING:
    from firstcontact.core import Dataset
    from firstcontact.models import AnytimeScores


def anytime_lines(
    folder: Path, dataset: Dataset, data: Path, contacts: str, detector: Path | None
) -> list[str]:
    """Scores of the any-time model of a folder, one line each.

    Raises
    ------
    InputError
        A damaged model, or no pinch that it can be asked about.
    """
    from firstcontact.contact import load_detector
    from firstcontact.models import (
        LabelledTouches,
        answers_by_time,
        anytime_scores,
        found,
        known,
        known_pinches,
        load_anytime,
        load_told_by,
        read_anytime_card,
    )

    model, card = load_anytime(folder), read_anytime_card(folder)
    familiar = known_pinches(dataset, card, load_told_by(folder))
    if not same_rate(dataset.layout.rate, model.rate):
        dataset = at_rate(dataset, model.rate, data)
    if aligned_by_truth(contacts, dataset, data):
        aligned = known(dataset)
    else:
        aligned = found(dataset, load_detector(detector or folder))
    asked = LabelledTouches.of(dataset, aligned.contacts)
    asked = asked.take(asked.touches.answerable)
    if not len(asked):
        raise InputError(
            f"{data}: none of {len(dataset)} pinches has a contact ({aligned.how}), a Shore A, and "
            f"{model.shortest} samples before its second contact"
        )
    lines = [
        f"at any time: contacts {aligned.how}; {counted(len(asked), 'pinch')} scored, "
        f"{len(dataset) - len(asked)} without contact or label, or ended by the second contact",
        *(familiar.warnings(asked.which) if familiar.by_samples else _flattered(card.pinches)),
    ]
    for title, which in familiar.groups().items():
        its = asked.take(which[asked.which])
        if len(its):
            scores = anytime_scores(
                answers_by_time(model, its.touches), its.shore_a, its.clusters, 0
            )
            constant = f"always answering their mean scores {its.shore_a.std():.2f}"
            lines += [
                f"{title}: {counted(len(its), 'pinch')}; rmse and width in Shore A ({constant})",
                *_table(scores, model.level),
            ]
    return lines


def _flattered(pinches: int) -> list[str]:
    """A note where an older firstcontact did not keep which pinches told a model of its rig."""
    if not pinches:
        return []
    return [
        f"note: the model knows its rig by {pinches} pinches and not which they were: about "
        "these very ones the scores below flatter"
    ]


def _table(scores: AnytimeScores, level: float) -> list[str]:
    head = (
        f"{'after contact':>13}  {'rmse':>6}  {f'in {100 * level:g} %':>8}  {'width':>6}  strange"
    )
    return [head] + [
        f"{ms + ' ms':>13}  {scores.rmse[ms]:>6.2f}  {percent(scores.coverage[ms]):>8}  "
        f"{scores.width[ms]:>6.1f}  {percent(scores.strange[ms]):>7}"
        for ms in scores.rmse
    ]
