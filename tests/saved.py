"""Changed copies of saved models and detectors."""

import hashlib
import json
from pathlib import Path
from typing import Any

from safetensors.numpy import load_file, save

from firstcontact.models import Model, WindowModel, WindowPredictor, load_model
from firstcontact.models.card import TrainingRecord
from firstcontact.models.rig.rig_model import RigModel

CARD, WEIGHTS = "model.json", "weights.safetensors"


def save_window(model: WindowModel, folder: Path, **fields: Any) -> Path:
    """Save a folder with only a window model. `fields` are the fields of its predictor's card."""
    return Model(predictors=(WindowPredictor(model, **fields),)).save(folder)


def load_window(folder: Path) -> WindowModel:
    """Load the window model of a folder."""
    return load_model(folder).windows[0].model


def save_network(model: RigModel, folder: Path, record: TrainingRecord = RigModel.record) -> Path:
    """Save a folder with only a network."""
    return Model(predictors=(model.with_record(record),)).save(folder)


def load_network(folder: Path) -> RigModel:
    """Load the network of a folder."""
    network = load_model(folder).network
    assert network is not None
    return network


def edit(folder: Path, card: str = CARD, **changes: Any) -> None:
    """Change fields in a card file.

    Each name is looked up in the card, then in its first predictor, and then in that predictor's
    ``record``.
    """
    fields = json.loads((folder / card).read_text(encoding="utf-8"))
    parts = [fields, *(fields.get("predictors") or [])[:1]]
    parts += [part["record"] for part in parts[1:]]
    for name, value in changes.items():
        next((part for part in parts if name in part), fields)[name] = value
    (folder / card).write_text(json.dumps(fields), encoding="utf-8")


def vouch(folder: Path, arrays: bytes, card: str = CARD, weights: str = WEIGHTS) -> None:
    """Replace the weights, and write a card with their checksum."""
    (folder / weights).write_bytes(arrays)
    edit(folder, card, sha256=hashlib.sha256(arrays).hexdigest())


def load_arrays(folder: Path) -> dict[str, Any]:
    """Return the arrays of the first predictor of a folder."""
    arrays = load_file(folder / WEIGHTS)
    return {n.removeprefix("0."): a for n, a in arrays.items() if n.startswith("0.")}


def replace_arrays(folder: Path, arrays: dict[str, Any]) -> None:
    """Replace the arrays of a folder's first predictor, and the checksum in the card."""
    vouch(folder, save({f"0.{name}": array for name, array in arrays.items()}))
