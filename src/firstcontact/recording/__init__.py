"""Recordings: one MCAP file each, a writer that survives being killed, a tolerant reader."""

from firstcontact.recording.dataset import load_dataset, write_dataset
from firstcontact.recording.header import Header, Marker, PinchMark
from firstcontact.recording.reader import Recording, read_recording
from firstcontact.recording.writer import RecordingWriter

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
