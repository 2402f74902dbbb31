"""Recordings: one MCAP file each, a writer that survives being killed, a tolerant reader."""

from __future__ import annotations

from typing import TYPE_CHECKING

from firstcontact.core.lazy import lazily

if TYPE_CHECKING:
    from firstcontact.recording.dataset import load_dataset, write_dataset
    from firstcontact.recording.header import Header, Marker, PinchMark
    from firstcontact.recording.reader import Recording, read_recording
    from firstcontact.recording.writer import RecordingWriter
else:
    __getattr__ = lazily(
        __name__,
        {
            "dataset": "load_dataset write_dataset",
            "header": "Header Marker PinchMark",
            "reader": "Recording read_recording",
            "writer": "RecordingWriter",
        },
    )

__all__ = [
    "Header",
    "Marker",
    "PinchMark",
    "Recording",
    "RecordingWriter",
    "load_dataset",
    "read_recording",
    "write_dataset",
]
