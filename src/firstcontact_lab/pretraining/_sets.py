"""Files with sets of examples. A set has several files; a resumed run reuses those that exist."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from pathlib import Path

import numpy as np
from safetensors.numpy import load_file, save

from firstcontact.core import Runner, replacing
from firstcontact_lab.pretraining._examples import Examples, joined, rig_examples
from firstcontact_lab.rigs import FAMILIES

#: Version of the files, raised when rigs, objects or stored values change. Older files are
#: replaced.
DRAWN = 1
#: Number of rigs in one file.
PART = 50


def example_set(
    folder: Path,
    first: int,
    rigs: int,
    seed: int,
    runner: Runner,
    family: str = "",
    again: int = 0,
    progress: Callable[[int], object] = lambda count: None,
) -> Examples:
    """Return the examples of ``rigs`` rigs from number ``first`` on."""
    folder.mkdir(parents=True, exist_ok=True)
    parts = [(at, min(PART, first + rigs - at)) for at in range(first, first + rigs, PART)]
    kind = (family or "rigs") + (f"-again{again}" if again else "")
    files = [folder / f"{kind}-v{DRAWN}-{seed}-{at}-{n}.safetensors" for at, n in parts]
    missing = [part for part, file in zip(parts, files, strict=True) if not file.exists()]
    made = iter(runner.stream(_part, missing, seed, family, again))
    out: list[Examples] = []
    for part, file in zip(parts, files, strict=True):
        if not file.exists():
            _write(file, next(made))
        out.append(_read(file))
        progress(part[1])
    return joined(out)


def _part(part: tuple[int, int], seed: int, family: str, again: int) -> Examples:
    first, rigs = part
    of = FAMILIES[family] if family else None
    numbers = range(first, first + rigs)
    return joined([rig_examples(number, seed, of, again) for number in numbers])


def _write(file: Path, examples: Examples) -> None:
    arrays = {f.name: np.ascontiguousarray(getattr(examples, f.name)) for f in fields(Examples)}
    with replacing(file) as temporary:
        temporary.write_bytes(save(arrays))


def _read(file: Path) -> Examples:
    return Examples(**load_file(file))
