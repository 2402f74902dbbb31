"""Saved models and detectors that were tampered with."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

from firstcontact.models import CARD
from firstcontact.models._model_file import WEIGHTS


def edit(folder: Path, card: str = CARD, **changes: Any) -> None:
    """Other fields in the card."""
    fields = json.loads((folder / card).read_text(encoding="utf-8"))
    (folder / card).write_text(json.dumps({**fields, **changes}), encoding="utf-8")


def vouch(folder: Path, arrays: bytes, card: str = CARD, weights: str = WEIGHTS) -> None:
    """Other weights with a card that vouches for them."""
    (folder / weights).write_bytes(arrays)
    edit(folder, card, sha256=hashlib.sha256(arrays).hexdigest())
