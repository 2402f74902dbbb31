"""Damaged model folders: cards, weights, and weights that the card vouches for all the same."""

from __future__ import annotations

import hashlib
import json
import shutil
import struct
from pathlib import Path
from random import Random
from typing import Any

import fuzz_mutate as mutate
import numpy as np
from safetensors.numpy import load, save

#: A card and the weights that it vouches for.
PAIRS = (("card.json", "model.safetensors"), ("detector.json", "detector.safetensors"))


def damaged(rng: Random, model: Path, folder: Path) -> None:
    """A copy of a model folder that was changed in one or two places."""
    shutil.copytree(model, folder)
    for _ in range(rng.choice((1, 1, 2))):
        card, weights = rng.choice((PAIRS[0], PAIRS[0], PAIRS[1]))
        kind = rng.randrange(10)
        if kind <= 3:
            _tree(rng, folder / card)
        elif kind <= 7 and (folder / weights).is_file():
            (folder / weights).write_bytes(_weights(rng, (folder / weights).read_bytes()))
            if rng.random() < 0.93:
                vouch(folder)
        elif kind == 8:
            file = folder / rng.choice((card, weights))
            if file.is_file():
                file.write_bytes(mutate.raw(rng, file.read_bytes()))
                if rng.random() < 0.5:
                    vouch(folder)
        else:
            _elsewhere(rng, folder, card, weights)


def vouch(folder: Path) -> None:
    """Have every card say the digests of the files as they are."""
    for _ in range(2):  # a card may vouch for another card
        for card in (pair[0] for pair in PAIRS):
            try:
                tree = json.loads((folder / card).read_bytes())
                _digests(tree, folder, card)
                (folder / card).write_text(json.dumps(tree))
            except (ValueError, OSError, AttributeError, RecursionError):
                continue


def _digests(tree: dict[str, Any], folder: Path, card: str) -> None:
    for key, old in list(tree.items()):
        if not (isinstance(old, str) and len(old) == 64):
            continue
        # "sha256" is of the weights beside the card; another name says which file it is of.
        of = dict(PAIRS)[card] if key == "sha256" else "detector.json"
        if (folder / of).is_file():
            tree[key] = hashlib.sha256((folder / of).read_bytes()).hexdigest()


def _tree(rng: Random, card: Path) -> None:
    if not card.is_file():
        return
    try:
        tree = json.loads(card.read_bytes())
    except (ValueError, RecursionError):
        return
    card.write_bytes(mutate.tree(rng, tree))
    if rng.random() < 0.8:
        vouch(card.parent)


def _weights(rng: Random, raw: bytes) -> bytes:
    """Other arrays, or another head over the same bytes."""
    try:
        arrays = load(raw)
    except Exception:  # it was damaged before
        return mutate.raw(rng, raw)
    if rng.random() < 0.7:
        for _ in range(rng.choice((1, 1, 2))):
            if not arrays:
                break
            name = rng.choice(sorted(arrays))
            kind = rng.randrange(8)
            if kind <= 5:
                arrays[name] = _array(rng, arrays[name])
            elif kind == 6:
                del arrays[name]
            else:
                arrays[rng.choice(sorted(arrays))] = arrays[name]
        try:
            return save(arrays)
        except Exception:  # a type that the format lacks
            return raw
    size = struct.unpack_from("<Q", raw)[0]
    head = mutate.tree(rng, json.loads(raw[8 : 8 + size]))
    said = len(head) if rng.random() < 0.95 else rng.choice((0, 2**31, 2**63, 2**64 - 1))
    return struct.pack("<Q", said) + head + raw[8 + size :]


def _array(rng: Random, old: Any) -> Any:
    new = mutate.array(rng, old)
    if new.dtype.kind in "fiub":
        return np.ascontiguousarray(new) if new.ndim else new
    return old.astype(rng.choice((np.float16, np.float32, np.float64, np.int64, np.uint8, bool)))


def _elsewhere(rng: Random, folder: Path, card: str, weights: str) -> None:
    """A file that is missing, empty, another one, or no file."""
    file = folder / rng.choice((card, weights))
    if file.is_dir():
        return
    file.unlink(missing_ok=True)
    kind = rng.randrange(5)
    if kind == 0:
        file.write_bytes(b"")
    elif kind == 1:
        file.mkdir()
    elif kind == 2:
        file.symlink_to(folder / rng.choice((card, weights, "nothing")))
    elif kind == 3:
        other = folder / ("card.json" if card != "card.json" else "detector.json")
        if other.is_file():
            shutil.copy(other, file)
