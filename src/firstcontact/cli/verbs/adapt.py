"""``firstcontact adapt``: a model of your own rig, in seconds."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from firstcontact.cli.choices import one_of
from firstcontact.contact import DETECTORS
from firstcontact.models import check_replaceable, replaced


@dataclass(frozen=True)
class Adapt:
    """Make a model that answers at any time after a contact, from a few pinches of known things."""

    data: tyro.conf.Positional[Path | None] = None
    """A recording, or a folder of them, of things of known Shore A; left out: a model that knows
    no rig, with intervals as wide as that makes them."""
    out: Path = Path("model")
    """Folder for the model and its detector; those that are in it are replaced whole."""
    detector: Annotated[str | None, one_of(DETECTORS)] = None
    """What finds contacts; left out: the usual one where it can learn from these pinches, else one
    that learns nothing; without recordings the one that was trained on the twin."""
    seed: int = 0
    """Of the folds in which the ways to know the rig are compared."""

    def run(self) -> None:
        """Condition the pre-trained network on the rig, save it, and print its held-out scores."""
        from firstcontact.core import replacing_folder
        from firstcontact.models import adapt
        from firstcontact.recording import load_dataset

        former = check_replaceable(self.out, (), anytime=True)
        data = None if self.data is None else load_dataset(self.data)
        with replacing_folder(self.out) as making:
            model = adapt(data, detector=self.detector, seed=self.seed)
            model.write(making)
        for line in model.notes:
            print(line)
        rig = "of an unknown rig " if data is None else ""
        print(f"any-time model {rig}and detector {model.own_detector.name}: {self.out}")
        if former:
            print(replaced(self.out))
