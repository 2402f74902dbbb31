"""Streams out of an XDF file: one clock, and every sample with its time."""

from __future__ import annotations

import logging
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import InputError, open_regular
from firstcontact.recording._apart import apart
from firstcontact.recording._memory import bounded_memory
from firstcontact.recording._quoting import reason
from firstcontact.recording._sizes import most_unpacked

#: How long a file may take, s, and bytes a second of it beside; what the library needs, bytes.
_SECONDS, _SPEED, _SPARE = 20.0, 5e5, 256 << 20


@dataclass(frozen=True, slots=True, eq=False)
class Stream:
    """What one stream holds.

    Parameters
    ----------
    name
        As its maker calls it.
    rate
        That it says it has, Hz; 0 where samples come as they like.
    channels
        Names of its channels, as many as there are columns; "" where it does not say them.
    units
        Of the channels.
    stamps
        Time of each sample on the clock of the recording, s, shape (samples,).
    values
        Shape (samples, channels); texts where the stream has texts.
    closed
        Whether the recording of it was ended properly.
    """

    name: str
    rate: float
    channels: tuple[str, ...]
    units: tuple[str, ...]
    stamps: NDArray[np.float64]
    values: NDArray[Any]
    closed: bool

    @property
    def says(self) -> bool:
        """Whether it holds texts."""
        return self.values.dtype.kind == "U"


def read_xdf(path: Path) -> list[Stream]:
    """All streams of a file, their clocks brought to one.

    Raises
    ------
    InputError
        The file cannot be read, or is damaged: what is behind the damage would be missing
        without a word.
    """
    try:
        open_regular(path).close()
        seconds = _SECONDS + path.stat().st_size / _SPEED
        return apart(seconds, _read, path)
    except InputError:
        raise
    except Exception as error:  # the library lets through whatever a damaged file leads to
        raise InputError(
            f"{path} cannot be read as XDF ({reason(error).rstrip('.')}): copy it again"
        ) from error


class _Complaints(logging.Handler):
    """What the library says of damage while it reads on behind it."""

    def __init__(self) -> None:
        super().__init__(logging.ERROR)
        self.said: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        self.said.append(record.getMessage())


def _read(path: Path) -> list[Stream]:
    """In a process of its own: what a damaged file declares is allocated."""
    import pyxdf

    complaints = _Complaints()
    log = logging.getLogger("pyxdf")
    log.handlers, log.propagate = [complaints], False
    with (
        bounded_memory(_SPARE + 4 * most_unpacked(path.stat().st_size)),
        np.errstate(all="ignore"),  # it divides by what stamps span, and we do not look at that
    ):
        # Stamps are smoothed later, where it is known what a gap is.
        streams, _ = pyxdf.load_xdf(path, dejitter_timestamps=False, verbose=None)
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
    labels, units = (
        [_described(info, k, what) for k in range(width)] for what in ("label", "unit")
    )
    return Stream(
        info["name"][0] or "",
        float(info["nominal_srate"][0]),
        tuple(labels),
        tuple(units),
        np.asarray(stream["time_stamps"], dtype=np.float64),
        values,
        "footer" in stream,
    )


def _described(info: dict[str, Any], channel: int, what: str) -> str:
    """A word of the description of a channel, which may lack anywhere."""
    try:
        return str(info["desc"][0]["channels"][0]["channel"][channel][what][0] or "")
    except (KeyError, IndexError, TypeError):
        return ""
