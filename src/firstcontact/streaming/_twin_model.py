"""Default model of a source: the twin's own, shipped or trained and cached, or the package's."""

from __future__ import annotations

import os
import sys
from importlib.metadata import version
from pathlib import Path

from firstcontact.device import Source
from firstcontact.models import Model, load_model, shipped_model

#: Folder of the model for the twin's default hand (``make twin-model``), with condition and seed.
SHIPPED = Path(__file__).parents[1] / "twin" / "pretrained"
SHIPPED_HAND = "paper-rig", 0
#: Number of training pinches of each block: few, to simulate and train in half a minute.
PINCHES = 60
#: Version of the training and of the model format; a new one replaces older models.
RECIPE = 6


def default_model(source: Source) -> Model:
    """Return the model for a source, open or not, for which the user names none.

    Only the twin's own model has a folder; the package's model knows no rig.
    """
    hand = source.twin_hand
    return shipped_model() if hand is None else load_model(twin_model(*hand))


def cache_folder() -> Path:
    """Return the folder of the cache, in ``XDG_CACHE_HOME`` or ``~/.cache``."""
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "firstcontact"


def twin_model(condition: str, seed: int) -> Path:
    """Return the folder of a model for the twin. If there is none, simulate pinches and train one.

    Parameters
    ----------
    condition
        Condition of the twin.
    seed
        Random seed of the twin. The training pinches differ from the pinches that the twin shows
        live.
    """
    if (condition, seed) == SHIPPED_HAND:
        return SHIPPED
    folder = cache_folder() / f"twin-{version('firstcontact')}.{RECIPE}-{condition}-{seed}"
    if (folder / "model.json").is_file():
        return folder
    from firstcontact.core import temporary_path
    from firstcontact.models import train
    from firstcontact.recording import load_dataset
    from firstcontact.twin import simulate

    print(
        f"no model is given: training one on the twin, kept in {folder} for the next start",
        file=sys.stderr,
    )
    with temporary_path(folder) as making:
        making.mkdir()
        simulate(making / "pinches", condition, PINCHES, pinches_per_object=0, seed=seed)
        model = train(load_dataset(making / "pinches"))
        model.save(making / "model")
        for line in model.notes:
            print(line, file=sys.stderr)
        try:
            (making / "model").rename(folder)
        except OSError:
            # Another run may have made the folder meanwhile.
            if not (folder / "model.json").is_file():
                raise
    return folder
