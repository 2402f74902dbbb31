"""Reader of NumPy archives. It checks declared sizes before it allocates memory."""

from __future__ import annotations

import math
import struct
import sys
import tokenize
import warnings
import zlib
from collections.abc import Collection
from pathlib import Path
from typing import IO, Any
from zipfile import ZIP_DEFLATED, ZIP_STORED, BadZipFile, ZipFile, ZipInfo

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from firstcontact.core import InputError, open_regular
from firstcontact.recording._quoting import reason
from firstcontact.recording._sizes import check_unpacked

_HEADERS = {b"\1\0": npy.read_array_header_1_0, b"\2\0": npy.read_array_header_2_0}
_ENCRYPTED = 0x1
_REMEDY = "save it with numpy.savez and without objects"
#: Errors of zipfile and NumPy's header parser for a damaged archive.
_DAMAGE = (
    OSError,
    ValueError,
    EOFError,
    TypeError,
    KeyError,
    IndexError,
    SyntaxError,
    RuntimeError,
    OverflowError,
    MemoryError,
    BadZipFile,
    zlib.error,
    struct.error,
    tokenize.TokenError,
)


def read_npz(path: Path, names: Collection[str]) -> tuple[dict[str, NDArray[Any]], list[str]]:
    """Read arrays by name. Return them, and the names of the arrays that were not read."""
    arrays: dict[str, NDArray[Any]] = {}
    unread = []
    try:
        with open_regular(path) as stream, ZipFile(stream) as archive:
            members = {i.filename.removesuffix(".npy"): i for i in archive.infolist()}
            wanted = {name: info for name, info in members.items() if name in names}
            unread = sorted(set(members) - set(wanted))
            check_unpacked(path, sum(info.file_size for info in wanted.values()))
            for name, info in wanted.items():
                _check_member(path, name, info)
                with archive.open(info) as member:
                    arrays[name] = _array(path, name, member, info.file_size)
    except InputError:
        raise
    except _DAMAGE as error:
        raise InputError(
            f"{path} cannot be read as an NPZ of plain arrays ({reason(error)}): {_REMEDY}"
        ) from error
    return arrays, unread


def _check_member(path: Path, name: str, info: ZipInfo) -> None:
    if info.flag_bits & _ENCRYPTED:
        raise InputError(f"{path}: '{name}' is encrypted: {_REMEDY}")
    if info.compress_type not in (ZIP_STORED, ZIP_DEFLATED):
        raise InputError(f"{path}: '{name}' has a compression that NumPy does not write: {_REMEDY}")


def _array(path: Path, name: str, member: IO[bytes], size: int) -> NDArray[Any]:
    magic = member.read(npy.MAGIC_LEN)
    read = _HEADERS.get(magic[-2:]) if magic.startswith(npy.MAGIC_PREFIX) else None
    if read is None:
        raise InputError(f"{path}: '{name}' is not a NumPy array: {_REMEDY}")
    with warnings.catch_warnings(action="ignore"):  # about headers of Python 2
        shape, fortran, dtype = read(member)
    if dtype.hasobject:
        raise InputError(f"{path}: '{name}' holds Python objects, which are not read: {_REMEDY}")
    available = size - member.tell()
    if math.prod(shape) * dtype.itemsize != available or any(n < 0 for n in shape):
        raise InputError(
            f"{path}: '{name}' declares the shape {shape} but holds {available} bytes: {_REMEDY}"
        )
    values: NDArray[Any] = np.frombuffer(member.read(), dtype)
    if dtype.kind == "U" and values.view(f"{dtype.byteorder}u4").max(initial=0) > sys.maxunicode:
        raise InputError(f"{path}: '{name}' holds invalid characters: {_REMEDY}")
    return values.reshape(shape, order="F" if fortran else "C")
