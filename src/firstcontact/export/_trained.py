"""What one training left behind, read for export: models, a detector, an any-time model."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from firstcontact.core import InputError

if TYPE_CHECKING:
    from firstcontact.contact import Detector
    from firstcontact.models import InContextModel, Interval, WindowModel


@dataclass(frozen=True, slots=True, eq=False)
class NamedModel:
    """A model of one window.

    Parameters
    ----------
    name
        Of its files and functions: a word of C.
    model, interval
        As they were saved; the latter is None where the model has none.
    """

    name: str
    model: WindowModel
    interval: Interval | None


@dataclass(frozen=True, slots=True, eq=False)
class Trained:
    """A training.

    Parameters
    ----------
    models
        Shortest window first; there may be none.
    detector, anytime
        None where there is none.
    """

    models: tuple[NamedModel, ...] = ()
    detector: Detector | None = None
    anytime: InContextModel | None = None

    @property
    def rate(self) -> float | None:
        """Sampling rate that its models learned at, Hz; None where there are none."""
        learned = [m.model.spec.rate for m in self.models]
        return next(iter(learned), None if self.anytime is None else self.anytime.rate)

    @property
    def parts(self) -> list[str]:
        """What there is, in words."""
        found = [f"{m.name}: {m.model.kind}, {m.model.spec.task}" for m in self.models]
        if self.detector is not None:
            found.append(f"detector: {self.detector.name}")
        return found + ([] if self.anytime is None else [f"anytime: {self.anytime.kind}"])


def load_trained(path: Path) -> Trained:
    """Read the folder of a training, or of one of its models.

    Raises
    ------
    InputError
        Nothing is there, or something that cannot be read.
    """
    from firstcontact.contact import CARD, load_detector
    from firstcontact.models import (
        has_anytime,
        has_models,
        load_anytime,
        load_interval,
        load_window_model,
        model_folders,
    )

    anytime = load_anytime(path) if has_anytime(path) else None
    detector = load_detector(path) if (path / CARD).exists() else None
    folders = model_folders(path) if has_models(path) else []
    models = tuple(
        NamedModel(
            "stiffness" if folder == path else "stiffness_" + re.sub(r"\W", "_", folder.name),
            load_window_model(folder),
            load_interval(folder),
        )
        for folder in folders
    )
    if not models and detector is None and anytime is None:
        raise InputError(
            f"{path}: no model is here: name a folder that `firstcontact train` or `adapt` wrote"
        )
    return Trained(models, detector, anytime)
