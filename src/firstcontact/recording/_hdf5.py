"""Reader of arrays in HDF5 files. It does not follow links out of the file."""

from __future__ import annotations

import math
from collections.abc import Collection
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import LONGEST_NAME, InputError, VibrationSensor, open_regular
from firstcontact.recording._quoting import as_text, reason
from firstcontact.recording._sizes import check_unpacked

#: Largest number of consecutive soft links.
_LINKS = 8
#: Largest attribute, bytes.
_ATTRIBUTE = 1 << 16
#: Largest number of texts read together, and largest size of them, bytes.
_TEXTS = 4096
_TEXT_BYTES = 64 << 20
#: Largest cell of a cell array, with one unpacked chunk, bytes.
_CELL = 16 * LONGEST_NAME
_DAMAGE = (
    OSError,
    RuntimeError,
    ValueError,
    KeyError,
    TypeError,
    NotImplementedError,
    OverflowError,
    MemoryError,
)


def read_hdf5(
    path: Path, names: Collection[str], settings: Collection[str]
) -> tuple[dict[str, NDArray[Any]], list[str]]:
    """Read datasets and attributes by name. Return them and the names that were not read."""
    try:
        open_regular(path).close()
        return _read(path, names, settings)
    except InputError:
        raise
    except _DAMAGE as error:
        raise InputError(
            f"{path} cannot be read as HDF5 ({reason(error)}): write it again"
        ) from error


def _read(
    path: Path, wanted: Collection[str], settings: Collection[str]
) -> tuple[dict[str, NDArray[Any]], list[str]]:
    """Return what :func:`read_hdf5` returns."""
    import h5py

    arrays: dict[str, NDArray[Any]] = {}
    with h5py.File(path, "r") as file:
        names = list(file.keys())
        datasets = {}
        for name in names:
            if name in wanted:
                _walk(path, file, name, name)
                if isinstance(file[name], h5py.Dataset):
                    datasets[name] = file[name]
        for name, dataset in datasets.items():
            _check(path, name, dataset)
        check_unpacked(path, sum(_declared(d) for d in datasets.values()))
        for name, dataset in datasets.items():
            arrays[name] = _values(path, name, dataset)
        for holder in (file, *map(datasets.get, VibrationSensor)):
            if holder is not None:
                arrays |= _attributes(path, holder.attrs, settings)
    return arrays, sorted(set(names) - set(wanted))


def _walk(path: Path, file: Any, name: str, target: str, left: int = _LINKS) -> None:
    """Raise an error if a link on the way to a name is broken or leads out of the file."""
    from h5py import Group, h5l

    group, gone = file, ""
    steps = [step for step in target.split("/") if step not in ("", ".")]
    for k, step in enumerate(steps):
        key = step.encode("utf-8", "surrogateescape")
        if not isinstance(group, Group) or not group.id.links.exists(key):
            raise InputError(
                f"{path}: '{name}' is a link to {target!r}, which does not exist: correct the link"
            )
        kind = group.id.links.get_info(key).type
        if kind == h5l.TYPE_SOFT and left:
            # Check the target of a link first, then the rest of the name.
            to = group.id.links.get_val(key).decode("utf-8", "surrogateescape")
            remainder = "/".join(steps[k + 1 :])
            base = "" if to.startswith("/") else gone
            return _walk(path, file, name, f"{base}/{to}/{remainder}", left - 1)
        if kind != h5l.TYPE_HARD:
            raise InputError(
                f"{path}: '{name}' is a link to another file, or begins a chain of too many "
                "links: copy its target into the file"
            )
        group, gone = group[step], f"{gone}/{step}"
    return None


def _check(path: Path, name: str, dataset: Any) -> None:
    """Raise an error for external storage, and for data that are neither numbers nor texts."""
    from h5py import Reference, check_ref_dtype, check_string_dtype

    if dataset.external or dataset.is_virtual:
        raise InputError(
            f"{path}: '{name}' is stored outside of its file or as a virtual dataset, which is "
            "not read: copy it into the file"
        )
    if dataset.shape is None:
        raise InputError(f"{path}: '{name}' is empty: give it values, or leave it out")
    is_cells = check_ref_dtype(dataset.dtype) is Reference and dataset.size in dataset.shape
    if dataset.dtype.hasobject and check_string_dtype(dataset.dtype) is None and not is_cells:
        raise InputError(
            f"{path}: '{name}' holds neither numbers nor texts: store numbers or texts"
        )


def _declared(dataset: Any) -> int:
    """Return the bytes that reading needs: the whole dataset, and one unpacked chunk."""
    chunk = math.prod(dataset.chunks or ())
    return int((math.prod(dataset.shape) + chunk) * max(dataset.dtype.itemsize, 1))


def _values(path: Path, name: str, dataset: Any) -> NDArray[Any]:
    from h5py import check_ref_dtype

    if check_ref_dtype(dataset.dtype) is not None:
        cells = [_cell(path, name, dataset.file[ref]) for ref in dataset[()].reshape(-1)]
        return np.array(cells, dtype=object)
    if not dataset.dtype.hasobject or dataset.ndim != 1:
        if dataset.dtype.hasobject and dataset.size > 1:
            raise InputError(
                f"{path}: '{name}' has the shape {dataset.shape}: give one text for each pinch"
            )
        return np.asarray(dataset[()])
    # Texts lie elsewhere in the file, and several may share one place.
    size = path.stat().st_size
    step = min(_TEXTS, max(1, _TEXT_BYTES // size))
    values: list[Any] = []
    for start in range(0, len(dataset), step):
        values += list(dataset[start : start + step])
        long = [text for text in values[start:] if len(text) > 4 * LONGEST_NAME]
        if long:
            raise InputError(
                f"{path}: '{name}' has a text of {len(long[0])} bytes: give at most "
                f"{LONGEST_NAME} characters"
            )
    return np.array(values, dtype=object)


def _cell(path: Path, name: str, target: Any) -> Any:
    """Return the text or number in a cell of MATLAB: a small dataset elsewhere in the file."""
    from h5py import Dataset

    refusal = InputError(
        f"{path}: a cell of '{name}' holds neither a number nor a text of at most {LONGEST_NAME} "
        "characters: correct it"
    )
    if not isinstance(target, Dataset) or target.dtype.kind not in "iuf":
        raise refusal
    _check(path, name, target)
    if _declared(target) > _CELL:
        raise refusal
    if "MATLAB_empty" in target.attrs:
        return ""
    values = np.asarray(target[()])
    if values.dtype == np.uint16 and as_text(target.attrs.get("MATLAB_class", "char")) == "char":
        return values.astype("<u2").tobytes().decode("utf-16-le", "replace")
    if values.size != 1:
        raise refusal
    return values.reshape(-1)[0]


def _attributes(path: Path, attributes: Any, settings: Collection[str]) -> dict[str, NDArray[Any]]:
    values = {}
    for name in settings:
        if name in attributes:
            if attributes.get_id(name).get_storage_size() > _ATTRIBUTE:
                raise InputError(f"{path}: the attribute '{name}' is too long: give a single value")
            values[name] = np.asarray(attributes[name])
    return values
