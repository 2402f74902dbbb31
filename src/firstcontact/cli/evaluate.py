"""``firstcontact evaluate``: a saved model asked about recordings."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import tyro

from firstcontact.cli.extras import need
from firstcontact.cli.train import aligned_by_truth, coverage_in_words, in_words
from firstcontact.core.errors import InputError

if TYPE_CHECKING:
    from firstcontact.stiffness import Interval, Model
    from firstcontact.study.training import Examples


@dataclass(frozen=True)
class Evaluate:
    """Score a saved model; pinches that it learned from are told apart."""

    model: tyro.conf.Positional[Path]
    """Folder of the model."""
    data: tyro.conf.Positional[Path]
    """A recording, or a folder of recordings."""
    contacts: Literal["auto", "truth", "detected"] = "auto"
    """Where windows start: known contacts, or those that the model's detector finds; auto: known if
    there are any."""

    def run(self) -> None:
        """Print errors or accuracy, and a table of objects."""
        import numpy as np

        from firstcontact.cli.losses import warn_of
        from firstcontact.contact.detector_file import load_detector
        from firstcontact.recording import load_dataset
        from firstcontact.stiffness import load_interval, load_model, read_card
        from firstcontact.study.alignment import found, known
        from firstcontact.study.training import examples

        card = read_card(self.model)
        if card.get("kind") == "cnn":
            need("cnn", "onnx", "onnxruntime")
        model, interval = load_model(self.model), load_interval(self.model)
        dataset = load_dataset(self.data)
        warn_of(dataset)
        model.spec.require_rate(dataset.layout.rate)
        target = card["data"].get("target", "shore_a")
        values = dataset.hardness_rank if target == "hardness_rank" else dataset.shore_a
        known_specimen = np.isin(dataset.specimens, card["data"]["specimens"]) & ~dataset.test
        # Other people's sessions have the same names: only together with source and specimen
        # does a name say that the model has learned from it.
        known_session = np.isin(dataset.sessions, card["data"]["sessions"]) & ~dataset.test
        known_session &= card["data"]["source"] == dataset.source
        learned = known_specimen & known_session
        if aligned_by_truth(self.contacts, dataset, self.data):
            contacts = known(dataset)
        else:
            contacts = found(dataset, load_detector(self.model))
        data = examples(dataset, contacts.contacts, model.spec.duration, values)
        if not len(data):
            raise InputError(
                f"{self.data}: none of {len(dataset)} pinches has a contact ({contacts.how}), a "
                f"whole window of {1e3 * model.spec.duration:.3g} ms and a {target}"
            )
        seen = learned[data.which]
        left_out = len(dataset) - len(data)
        print(f"contacts {contacts.how}")
        print(f"{len(data)} pinches scored, {left_out} without contact or label")
        if seen.any():
            print(
                f"warning: {seen.sum()} pinches are of sessions and specimens that the model "
                "learned from: they are reported apart and say nothing of its errors in use"
            )
        other_session = known_specimen[data.which] & ~seen
        same_session = known_session[data.which] & ~seen
        for title, which in (
            ("not seen in training", ~seen & ~other_session & ~same_session),
            ("sessions of the training by name, other specimens", same_session),
            ("specimens of the training, other sessions", other_session),
            ("seen in training", seen),
        ):
            if which.any():
                _report(title, model, interval, data.take(which), target)


def _report(
    title: str, model: Model, interval: Interval | None, data: Examples, target: str
) -> None:
    import numpy as np

    from firstcontact.study.keeping import covered, score

    if model.spec.classes:
        inside = np.isin(data.y, model.spec.classes)
        if not inside.all():
            print(
                f"{title}: {(~inside).sum()} pinches are of no class that the model knows "
                "and are left out"
            )
        data = data.take(inside)
    if not len(data):
        return
    predicted = model.predict(data.X)
    print(f"{title}: {in_words(score(model.spec.task, data, predicted, seed=0))}")
    held = covered(interval, predicted, data.y)
    if interval is not None:
        print(f"  {coverage_in_words(held, interval.level)}")
    elif not model.spec.classes:
        print("  the model has no interval")
    for line in _table(data, predicted, target):
        print(f"  {line}")


def _table(data: Examples, predicted: Any, target: str) -> list[str]:
    from firstcontact.study.metrics import per_object

    each = per_object(data.y, predicted, data.specimens, data.objects)
    names = {name: name or "(unnamed)" for name in each}
    width = max(len(n) for n in (*names.values(), "specimen"))
    unit = "true" if target == "shore_a" else "rank"
    lines = [f"{'specimen':<{width}}  {'n':>5}  {unit:>6}  {'mean':>6}  {'sd':>5}  {'rmse':>5}"]
    for name, row in each.items():
        spread = f"{row['sd']:.1f}" if "sd" in row else "–"
        lines.append(
            f"{names[name]:<{width}}  {row['n']:>5}  {row['true']:>6.1f}  {row['mean']:>6.1f}  "
            f"{spread:>5}  {row['rmse']:>5.1f}"
        )
    return lines
