"""Damaged model folders: cards and weights, some with correct digests."""

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


def damaged(rng: Random, model: Path, folder: Path) -> None:
    """Return a copy of a model folder with one or two changes."""
    shutil.copytree(model, folder)
    files = sorted(file.name for file in model.iterdir())
    learned = [name for name in files if name.startswith(("model", "weights"))]
    for _ in range(rng.choice((1, 1, 2))):
        file = folder / rng.choice((*files, *learned))
        kind = rng.random()
        if not file.is_file() or kind < 0.05:
            _elsewhere(rng, file, folder / rng.choice(files))
        elif kind < 0.15:
            file.write_bytes(mutate.raw(rng, file.read_bytes()))
        elif file.suffix == ".json":
            file.write_bytes(_tree(rng, file.read_bytes()))
        elif file.suffix == ".safetensors":
            file.write_bytes(_weights(rng, file.read_bytes()))
        else:
            file.write_bytes(mutate.raw(rng, file.read_bytes()))
    if rng.random() < 0.93:
        _vouch(model, folder)


def _vouch(model: Path, folder: Path) -> None:
    """Write the digests of the damaged files into the cards."""
    cards = sorted(folder.glob("*.json"), reverse=True)  # a model's says that of its detector's
    for file in (*(f for f in sorted(model.iterdir()) if f.suffix != ".json"), *cards):
        original, now = model / file.name, folder / file.name
        if not (original.is_file() and now.is_file()):
            continue
        old, new = (hashlib.sha256(f.read_bytes()).hexdigest() for f in (original, now))
        for card in cards:
            if old != new and card.is_file() and not card.is_symlink():
                card.write_bytes(card.read_bytes().replace(old.encode(), new.encode()))


def _tree(rng: Random, card: bytes) -> bytes:
    try:
        return mutate.tree(rng, json.loads(card))
    except (ValueError, RecursionError):  # it was damaged before
        return mutate.raw(rng, card)


def _weights(rng: Random, raw: bytes) -> bytes:
    """Return a weights file with other arrays, or with another header before the same bytes."""
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
    length = len(head) if rng.random() < 0.95 else rng.choice((0, 2**31, 2**63, 2**64 - 1))
    return struct.pack("<Q", length) + head + raw[8 + size :]


def _array(rng: Random, old: Any) -> Any:
    if rng.random() < 0.2:  # what overflows only when it is multiplied
        with np.errstate(all="ignore"):
            return (old * 10.0 ** rng.randint(-45, 38)).astype(old.dtype)
    new = mutate.array(rng, old)
    if new.dtype.kind in "fiub":
        return np.ascontiguousarray(new) if new.ndim else new
    return old.astype(rng.choice((np.float16, np.float32, np.float64, np.int64, np.uint8, bool)))


def _elsewhere(rng: Random, file: Path, other: Path) -> None:
    """Remove a file, or replace it by an empty file, another file, or a folder."""
    if file.is_dir():
        return
    file.unlink(missing_ok=True)
    kind = rng.randrange(5)
    if kind == 0:
        file.write_bytes(b"")
    elif kind == 1:
        file.mkdir()
    elif kind == 2:
        file.symlink_to(other)
    elif kind == 3 and other.is_file():
        shutil.copy(other, file)
