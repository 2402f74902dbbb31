"""Saved models that were tampered with."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

from firstcontact.stiffness.model_file import CARD, WEIGHTS


def edit(folder: Path, **changes: Any) -> None:
    """Other fields in the card."""
    card = json.loads((folder / CARD).read_text(encoding="utf-8"))
    (folder / CARD).write_text(json.dumps({**card, **changes}), encoding="utf-8")


def vouch(folder: Path, weights: bytes) -> None:
    """Other weights with a card that vouches for them."""
    (folder / WEIGHTS).write_bytes(weights)
    edit(folder, sha256=hashlib.sha256(weights).hexdigest())
