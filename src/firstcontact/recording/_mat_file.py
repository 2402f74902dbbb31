"""Reader of variables in MATLAB files of any version."""

from __future__ import annotations

import math
import os
import struct
from collections.abc import Collection
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import InputError, open_regular
from firstcontact.recording._hdf5 import read_hdf5
from firstcontact.recording._quoting import reason
from firstcontact.recording._sizes import check_unpacked

#: Start of a file of version 7.3, which is HDF5 after 512 bytes.
_HDF5 = b"MATLAB 7.3"
#: Header of a version 5 file, bytes. Its last two bytes give the byte order.
_HEAD = 128
Arrays = dict[str, NDArray[Any]]


def read_mat(path: Path, names: Collection[str]) -> tuple[Arrays, list[str]]:
    """Read variables by name. Return them, and the names of the variables that were not read."""
    try:
        with open_regular(path) as stream:
            new = stream.read(len(_HDF5)) == _HDF5
        if new:
            arrays, unread = read_hdf5(path, names, ())
            # HDF5 stores the dimensions in reverse order, and texts as character codes.
            return {name: values.T for name, values in arrays.items()}, unread
        return _read(path, names)
    except InputError:
        raise
    except Exception as error:  # damage can cause any error in the library
        raise InputError(
            f"{path} cannot be read as a MATLAB file ({reason(error).rstrip('.')}): save it again"
        ) from error


def text_of_codes(values: NDArray[Any]) -> str:
    """Return a text from its character codes, as MATLAB files of version 7.3 store it."""
    codes = values.reshape(-1).astype(np.int64)
    return "".join(map(chr, codes)) if ((codes > 0) & (codes < 0xD800)).all() else ""


def _read(path: Path, names: Collection[str]) -> tuple[Arrays, list[str]]:
    """Return what :func:`read_mat` returns, for files before version 7.3."""
    from scipy.io import loadmat

    with open_regular(path) as stream:
        _check_length(path, stream)
        members = _names(path, stream, names)
        stream.seek(0)
        loaded = loadmat(stream, variable_names=[n for n in members if n in names])
    arrays = {name: _plain(path, name, loaded[name]) for name in members if name in names}
    return arrays, sorted(set(members) - set(names))


def _check_length(path: Path, stream: IO[bytes]) -> None:
    """Raise an error if a file of version 5 is truncated, which SciPy does not always notice."""
    head = stream.read(_HEAD)
    order = {b"IM": "<", b"MI": ">"}.get(head[-2:])
    while order and (tag := stream.read(8)):
        size = struct.unpack(f"{order}I", tag[4:])[0] if len(tag) == 8 else 1
        if len(tag) < 8 or stream.seek(size, os.SEEK_CUR) > path.stat().st_size:
            raise InputError(f"{path} ends within a variable: copy it again")
    stream.seek(0)


def _names(path: Path, stream: IO[bytes], wanted: Collection[str]) -> list[str]:
    from scipy.io import whosmat

    listing = whosmat(stream)
    names = [name for name, _, _ in listing]
    doubled = sorted({name for name in names if names.count(name) > 1})
    if doubled:
        raise InputError(
            f"{path} has the variable {doubled[0]!r} twice: save the file again with one of them"
        )
    sizes = [math.prod(shape) * 8 for name, shape, _ in listing if name in wanted]
    check_unpacked(path, sum(sizes))
    return names


def _plain(path: Path, name: str, values: Any) -> NDArray[Any]:
    """Return a variable's numbers or texts. A cell array becomes an array of its values."""
    array = np.asarray(values) if isinstance(values, np.ndarray) else None
    if array is not None and array.dtype == object and array.dtype.names is None:
        cells = [np.asarray(cell) for cell in array.reshape(-1)]
        if all(c.dtype.kind in "iufU" and c.size <= 1 for c in cells):
            return np.array([c.reshape(-1)[0] if c.size else "" for c in cells], object)
        array = None
    if array is None or array.dtype.kind not in "iufbU":
        raise InputError(
            f"{path}: the variable '{name}' holds neither numbers nor texts: save numbers or texts"
        )
    return array
