"""Reader of arrays in HDF5 files. It reads nothing outside of the file."""

from __future__ import annotations

import math
from collections.abc import Collection
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import InputError, VibrationSensor
from firstcontact.core.files import open_regular
from firstcontact.core.installation import require_modules
from firstcontact.core.records import LONGEST_NAME
from firstcontact.recording.untrusted import check_unpacked, library_errors

#: Largest size of texts that are read together, bytes.
_TEXT_BYTES = 64 << 20


def read_hdf5(
    path: Path, names: Collection[str], settings: Collection[str] = ()
) -> tuple[dict[str, NDArray[Any]], list[str]]:
    """Read datasets and attributes by name. Return them and the names that were not read."""
    require_modules("files", "h5py")
    with library_errors(path, "HDF5", "write it again"):
        open_regular(path).close()
        import h5py

        arrays: dict[str, NDArray[Any]] = {}
        with h5py.File(path, "r") as file:
            for name in (wanted := [name for name in file if name in names]):
                if not isinstance(file.get(name, getlink=True), h5py.HardLink):
                    raise InputError(f"{path}: '{name}' is a link: copy its target into the file")
            datasets = {n: file[n] for n in wanted if isinstance(file[n], h5py.Dataset)}
            for name, dataset in datasets.items():
                _check(path, name, dataset)
            check_unpacked(path, sum(_declared(d) for d in datasets.values()))
            for name, dataset in datasets.items():
                arrays[name] = _values(path, name, dataset)
            for holder in (file, *map(datasets.get, VibrationSensor)):
                for name in settings if holder is not None else ():
                    if name in holder.attrs:
                        arrays[name] = np.asarray(holder.attrs[name])
            return arrays, sorted(set(file) - set(wanted))


def _check(path: Path, name: str, dataset: Any) -> None:
    """Raise an error for data outside of the file, and for neither numbers nor texts."""
    from h5py import check_string_dtype

    if dataset.external or dataset.is_virtual:
        raise InputError(
            f"{path}: '{name}' is stored outside of its file or as a virtual dataset, which is "
            "not read: copy it into the file"
        )
    if dataset.shape is None:
        raise InputError(f"{path}: '{name}' is empty: give it values, or leave it out")
    is_texts = check_string_dtype(dataset.dtype) is not None and dataset.size in (*dataset.shape, 1)
    if dataset.dtype.hasobject and not is_texts:
        raise InputError(
            f"{path}: '{name}' holds neither numbers nor one text for each pinch: store those, or "
            "save a MATLAB file with -v7"
        )


def _declared(dataset: Any) -> int:
    """Return the bytes that reading needs: the whole dataset, and one unpacked chunk."""
    chunk = math.prod(dataset.chunks or ())
    return int((math.prod(dataset.shape) + chunk) * max(dataset.dtype.itemsize, 1))


def _values(path: Path, name: str, dataset: Any) -> NDArray[Any]:
    if not dataset.dtype.hasobject or not dataset.ndim:
        return np.asarray(dataset[()])
    # Texts lie elsewhere in the file, and several may share one place, so few are read together.
    step = max(1, _TEXT_BYTES // path.stat().st_size)
    texts: list[Any] = []
    for start in range(0, len(dataset), step):
        texts += list(dataset[start : start + step].reshape(-1))
        if (longest := max(map(len, texts[start:]))) > 4 * LONGEST_NAME:
            raise InputError(
                f"{path}: '{name}' holds a text of {longest} bytes: shorten it to {LONGEST_NAME} "
                "characters or fewer"
            )
    return np.array(texts, dtype=object)
