"""Default model for a source: the package's, or for the twin one that is trained if needed."""

from __future__ import annotations

import sys
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING

from firstcontact.core.files import cache_path, make_once
from firstcontact.core.installation import require_extra
from firstcontact.device import Source

if TYPE_CHECKING:
    from firstcontact.models import Model

#: Folder of the model for the twin's default hand (``make twin-model``), with condition and seed.
SHIPPED = Path(__file__).parents[1] / "twin" / "pretrained"
SHIPPED_HAND = "paper-rig", 0
#: Number of training pinches of each block: few, to simulate and train in half a minute.
PINCHES = 60


def default_model(source: Source) -> Model:
    """Return the model that is used for a source if the user names none."""
    from firstcontact.models import load_model
    from firstcontact.models.model import shipped_model

    hand = source.twin_hand
    return shipped_model() if hand is None else load_model(twin_model(*hand))


def twin_model(condition: str, seed: int) -> Path:
    """Return the folder of a model for the twin in this condition and with this random seed.

    Train the model if the folder does not exist.
    """
    from firstcontact.models import ESTIMATORS
    from firstcontact.twin.samples import RECIPE

    if (condition, seed) == SHIPPED_HAND:
        return SHIPPED
    require_extra(ESTIMATORS[ESTIMATORS.default])  # before the simulation
    folder = cache_path(f"twin-{version('firstcontact')}.{RECIPE}-{condition}-{seed}")

    def make(making: Path) -> None:
        from firstcontact.models import train
        from firstcontact.recording.dataset import load
        from firstcontact.twin.simulation import simulate_recordings

        print(
            f"no model was given; training one on the twin, saved in {folder} for the next start",
            file=sys.stderr,
        )
        pinches = making.with_name("pinches")
        simulate_recordings(pinches, condition, PINCHES, pinches_per_object=0, seed=seed)
        model = train(load(pinches))
        model.save(making)
        for line in model.notes:
            print(line, file=sys.stderr)

    make_once(folder, make)
    return folder
