"""``firstcontact evaluate``: a saved model asked about recordings."""

from __future__ import annotations

import logging
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import tyro

from firstcontact.cli.verbs.train import (
    UNITS,
    aligned_by_truth,
    at_rate,
    coverage_in_words,
    in_words,
)
from firstcontact.core import InputError, counted

if TYPE_CHECKING:
    from firstcontact.core import Dataset
    from firstcontact.models import Interval, LabelledWindows, WindowModel

_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Evaluate:
    """Score a saved model, an any-time one from 2 to 15 ms after the contact.

    Pinches that it learned from, or knows its rig by, are told apart.
    """

    model: tyro.conf.Positional[Path]
    """Folder of the model."""
    data: tyro.conf.Positional[Path]
    """A recording, or a folder of recordings."""
    contacts: Literal["auto", "truth", "detected"] = "auto"
    """Where windows start: known contacts, or those that the model's detector finds; auto: known if
    there are any."""
    detector: Path | None = None
    """Folder of another detector than the one beside the model."""

    def run(self) -> None:
        """Print errors or accuracy, and a table of objects."""
        from firstcontact.cli.evaluate_anytime import anytime_lines
        from firstcontact.cli.losses import warn_of
        from firstcontact.models import CARD, has_anytime, has_models, model_folders
        from firstcontact.recording import load_dataset

        at_any_time = has_anytime(self.model)
        # Both kinds may lie in one folder.
        fixed = not at_any_time or (self.model / CARD).is_file()
        folder = _one_folder(self.model) if fixed else self.model
        loaded = load_dataset(self.data)
        warn_of(loaded)
        if at_any_time:
            asked = loaded, self.data, self.contacts, self.detector
            for line in anytime_lines(self.model, *asked):
                print(line)
            if not fixed and has_models(self.model):
                names = ", ".join(f.name for f in model_folders(self.model))
                print(f"models of fixed windows are here, too: name one of {names} to score it")
        if fixed:
            self._window(folder, loaded)

    def _window(self, folder: Path, loaded: Dataset) -> None:
        """Score a model of one window length."""
        from firstcontact.contact import load_detector
        from firstcontact.models import (
            found,
            known,
            known_pinches,
            labelled_windows,
            load_digests,
            load_interval,
            load_window_model,
            read_card,
        )

        card = read_card(folder)
        model, interval = load_window_model(folder), load_interval(folder)
        _log.info("model %s: %s", folder, model.spec)
        familiar = known_pinches(loaded, card.data, load_digests(folder))
        dataset = _at_rate_of(loaded, model.spec.rate, self.data, folder)
        target = card.data.target
        values = dataset.hardness_rank if target == "hardness_rank" else dataset.shore_a
        if aligned_by_truth(self.contacts, dataset, self.data):
            contacts = known(dataset)
        else:
            contacts = found(dataset, load_detector(self.detector or folder))
        data = labelled_windows(dataset, contacts.contacts, model.spec.duration, values)
        if not len(data):
            raise InputError(
                f"{self.data}: none of {len(dataset)} pinches has a contact ({contacts.how}), a "
                f"whole window of {1e3 * model.spec.duration:.3g} ms and a {target}"
            )
        print(f"contacts {contacts.how}")
        print(
            f"{counted(len(data), 'pinch')} scored, "
            f"{len(dataset) - len(data)} without contact or label"
        )
        for line in familiar.warnings(data.which):
            print(line)
        for title, which in familiar.groups().items():
            if which[data.which].any():
                _report(title, model, interval, data.take(which[data.which]), target)


def _one_folder(path: Path) -> Path:
    """Folder of the one model that is there."""
    from firstcontact.models import model_folders

    folder, *others = model_folders(path)
    if others:
        raise InputError(
            f"{path} holds models of several window lengths: name one of them, such as {folder}"
        )
    return folder


def _at_rate_of(dataset: Dataset, rate: float, data: Path, model: Path) -> Dataset:
    """The pinches at the model's rate, as a study would resample them; says what was done."""
    from firstcontact.recording import check_rate

    check_rate(f"{model}: rate_hz", rate)
    resampled = at_rate(dataset, rate, data)
    recorded = dataset.layout.rate
    if recorded == rate:
        return dataset
    if recorded < rate:
        print(
            f"warning: these recordings hold nothing above {recorded / 2:g} Hz, and the model may "
            "have learned from what is there"
        )
    print(f"live does not resample: for a device at {recorded:g} Hz train with --rate {recorded:g}")
    return resampled


def _report(
    title: str, model: WindowModel, interval: Interval | None, data: LabelledWindows, target: str
) -> None:
    import numpy as np

    from firstcontact.models import covered, score

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
    print(f"{title}: {in_words(score(model.spec.task, data, predicted, seed=0), target)}")
    held = covered(interval, predicted, data.y, model.spread(data.X))
    if interval is not None:
        print(f"  {coverage_in_words(held, interval.level)} {UNITS[target]}")
    elif not model.spec.classes:
        print("  the model has no interval")
    for line in _table(data, predicted, target):
        print(f"  {line}")


def _table(data: LabelledWindows, predicted: Any, target: str) -> list[str]:
    from firstcontact.models import per_object

    each = per_object(data.y, predicted, data.specimens, data.objects)
    names = {name: name or "(unnamed)" for name in each}
    width = max(len(n) for n in (*names.values(), "specimen"))
    unit = "true" if target == "shore_a" else "rank"
    lines = [f"{'specimen':<{width}}  {'n':>5}  {unit:>6}  {'mean':>6}  {'sd':>5}  {'rmse':>5}"]
    for name, row in each.items():
        spread = f"{row.sd:.1f}" if row.sd is not None else "–"
        lines.append(
            f"{names[name]:<{width}}  {row.n:>5}  {row.true:>6.1f}  {row.mean:>6.1f}  "
            f"{spread:>5}  {row.rmse:>5.1f}"
        )
    return lines
