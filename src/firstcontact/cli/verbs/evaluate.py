"""Command ``firstcontact evaluate``: scores of a saved model on recordings."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from firstcontact.cli.options import Option
from firstcontact.core.quantity import RANK
from firstcontact.core.text import counted, percent

if TYPE_CHECKING:
    from firstcontact import GroupScores
    from firstcontact.core import Dataset
    from firstcontact.models import Evaluation, Model


@dataclass(frozen=True)
class Evaluate:
    """Score a saved model on recordings.

    Pinches that the model was trained on are scored separately.
    """

    model: Annotated[Path, Option(positional=True)]
    """Folder of the model."""
    data: Annotated[Path, Option(positional=True)]
    """A recording, or a folder of recordings."""
    contacts: Literal["detected", "known"] = "detected"
    """Contacts where signals start: from the detector, or the true ones."""
    detector: Path | None = None
    """Folder of a contact detector that replaces the model's detector."""

    def run(self) -> None:
        from firstcontact.cli.output import print_losses
        from firstcontact.contact import load_detector
        from firstcontact.models import evaluate, load_model
        from firstcontact.recording import load_dataset

        detector = None if self.detector is None else load_detector(self.detector)
        model = load_model(self.model, detector)
        data = load_dataset(self.data)
        print_losses(data)
        for line in _rate_lines(model, data):
            print(line)
        with_shapes = model.trained_on.with_shapes(data)
        shapes = sum(bool(pinch.label.shape) for pinch in with_shapes)
        if shapes and model.network is not None:
            print(f"the network uses the shape in {shapes} of {counted(len(data), 'pinch')}")
        for evaluation in evaluate(model, data, contacts=self.contacts):
            for line in _lines(evaluation):
                print(line)


def _rate_lines(model: Model, data: Dataset) -> Iterator[str]:
    recorded = data.layout.rate
    if not model.prediction_times or recorded == model.rate:
        return
    yield f"Resampled from {recorded:g} Hz to {model.rate:g} Hz, the rate of the model"
    if recorded < model.rate:
        yield (
            f"warning: these recordings hold nothing above {recorded / 2:g} Hz, but the model may "
            "have learned from higher frequencies"
        )


def _lines(evaluation: Evaluation) -> Iterator[str]:
    yield (
        f"{evaluation.when}, {evaluation.predictor}: contacts {evaluation.contacts}; "
        f"{counted(evaluation.scored, 'pinch')} scored, {evaluation.left_out} left out (no "
        "contact, label, known class or enough signal before the second contact)"
    )
    yield from evaluation.warnings
    for group in evaluation.groups:
        if evaluation.duration is None:
            yield from _network_lines(group)
        else:
            yield from _window_lines(group, evaluation)


def _network_lines(group: GroupScores) -> Iterator[str]:
    constant = f"always predicting their mean scores {group.constant:.2f}"
    yield f"{group.title}: {counted(group.n, 'pinch')}; rmse and width in Shore A ({constant})"
    share = f"in {100 * (group.level or 0):g} %"
    yield f"{'after contact':>13}  {'rmse':>6}  {'bias':>6}  {share:>8}  {'width':>6}  out of range"
    for at, rmse in group.rmse.items():
        yield (
            f"{f'{1e3 * at:g} ms':>13}  {rmse:>6.2f}  {group.bias[at]:>+6.2f}  "
            f"{percent(group.coverage[at]):>8}  {group.width[at]:>6.1f}  "
            f"{percent(group.out_of_range[at]):>12}"
        )


def _window_lines(group: GroupScores, evaluation: Evaluation) -> Iterator[str]:
    from firstcontact.models.training import scores_in_words

    quantity = evaluation.quantity
    (scores,) = group.scores.values()
    yield f"{group.title}: {scores_in_words(scores, quantity)}"
    for at, coverage in group.coverage.items():
        yield (
            f"  interval at level {group.level:g} held the truth in {percent(coverage)} of "
            f"{group.n} pinches, mean width "
            f"{quantity.width_words(group.width[at])}"
        )
    if group.level is None and group.rmse:
        yield "  the model has no interval"
    names = {name: name or "(unnamed)" for name in group.objects}
    width = max(len(n) for n in (*names.values(), "specimen"))
    true = "rank" if quantity is RANK else "true"
    if quantity.is_logarithmic:
        yield f"  true and mean in {quantity.unit}; sd and rmse are errors of its logarithm"
    yield f"  {'specimen':<{width}}  {'n':>5}  {true:>6}  {'mean':>6}  {'sd':>5}  {'rmse':>5}"
    places = 2 if quantity.is_logarithmic else 1
    for name, row in group.objects.items():
        spread = f"{row.sd:.{places}f}" if row.sd is not None else "–"
        yield (
            f"  {names[name]:<{width}}  {row.n:>5}  {row.true:>6.1f}  {row.mean:>6.1f}  "
            f"{spread:>5}  {row.rmse:>5.{places}f}"
        )
