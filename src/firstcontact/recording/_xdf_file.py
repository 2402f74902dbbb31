"""Reader of XDF streams, with one clock and the time of every sample."""

from __future__ import annotations

import logging
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import InputError, open_regular
from firstcontact.recording._quoting import reason


@dataclass(frozen=True, slots=True, eq=False)
class Stream:
    """Contents of one XDF stream."""

    name: str
    rate: float
    channels: tuple[str, ...]
    units: tuple[str, ...]
    stamps: NDArray[np.float64]
    values: NDArray[Any]
    closed: bool

    @property
    def is_text(self) -> bool:
        """Return True if the samples are texts."""
        return self.values.dtype.kind == "U"


def read_xdf(path: Path) -> list[Stream]:
    """Read all streams of a file, with times on one clock."""
    try:
        with open_regular(path) as stream:  # the library does not close a file that it refuses
            return _read(stream)
    except InputError:
        raise
    except Exception as error:  # damage can cause any error in the library
        raise InputError(
            f"{path} cannot be read as XDF ({reason(error).rstrip('.')}): copy it again"
        ) from error


class _Complaints(logging.Handler):
    """Log handler that collects the warnings of pyxdf about damage."""

    def __init__(self) -> None:
        super().__init__(logging.ERROR)
        self.said: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        self.said.append(record.getMessage())


def _read(file: IO[bytes]) -> list[Stream]:
    """Return all streams of a file."""
    import pyxdf

    complaints = _Complaints()
    log = logging.getLogger("pyxdf")
    before = log.handlers, log.propagate
    log.handlers, log.propagate = [complaints], False
    try:
        # The library divides by the span of the stamps, which is not used here.
        with np.errstate(all="ignore"):
            # Stamps are smoothed later, when gaps are known.
            streams, _ = pyxdf.load_xdf(file, dejitter_timestamps=False, verbose=None)
    finally:
        log.handlers, log.propagate = before
    if complaints.said:
        raise OSError(complaints.said[0])
    return [_stream(stream) for stream in streams]


def _stream(stream: dict[str, Any]) -> Stream:
    info = stream["info"]
    values = stream["time_series"]
    if isinstance(values, list):
        values = np.array(
            [" ".join(map(str, row)) for row in values] or np.zeros(0, "U1"), dtype=np.str_
        ).reshape(-1, 1)
    width = values.shape[1]
    labels, units = ([_described(info, k, key) for k in range(width)] for key in ("label", "unit"))
    return Stream(
        info["name"][0] or "",
        float(info["nominal_srate"][0]),
        tuple(labels),
        tuple(units),
        np.asarray(stream["time_stamps"], dtype=np.float64),
        values,
        "footer" in stream,
    )


def _described(info: dict[str, Any], channel: int, key: str) -> str:
    """Return a field of a channel's description; "" if it is missing."""
    try:
        return str(info["desc"][0]["channels"][0]["channel"][channel][key][0] or "")
    except (KeyError, IndexError, TypeError):
        return ""
