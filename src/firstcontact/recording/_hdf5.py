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
from firstcontact.recording.untrusted import as_text, check_unpacked, library_errors

#: Largest number of texts read together, and largest size of them, bytes.
_TEXTS = 4096
_TEXT_BYTES = 64 << 20
#: Largest cell of a cell array, with one unpacked chunk, bytes.
_CELL = 16 * LONGEST_NAME


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
    from h5py import Reference, check_ref_dtype, check_string_dtype

    if dataset.external or dataset.is_virtual:
        raise InputError(
            f"{path}: '{name}' is stored outside of its file or as a virtual dataset, which is "
            "not read: copy it into the file"
        )
    if dataset.shape is None:
        raise InputError(f"{path}: '{name}' is empty: give it values, or leave it out")
    is_cells = check_ref_dtype(dataset.dtype) is Reference and dataset.size in dataset.shape
    is_texts = check_string_dtype(dataset.dtype) is not None and dataset.size in (*dataset.shape, 1)
    if dataset.dtype.hasobject and not is_texts and not is_cells:
        raise InputError(
            f"{path}: '{name}' holds neither numbers nor one text for each pinch: store those"
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
    if not dataset.dtype.hasobject or not dataset.ndim:
        return np.asarray(dataset[()])
    # Texts lie elsewhere in the file, and several may share one place.
    step = min(_TEXTS, max(1, _TEXT_BYTES // path.stat().st_size))
    texts: list[Any] = []
    for start in range(0, len(dataset), step):
        texts += list(dataset[start : start + step].reshape(-1))
        longest = max(map(len, texts[start:]))
        if longest > 4 * LONGEST_NAME:
            raise InputError(
                f"{path}: '{name}' has a text of {longest} bytes: give at most {LONGEST_NAME} "
                "characters"
            )
    return np.array(texts, dtype=object)


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
