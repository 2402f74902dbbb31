"""Recordings: one MCAP file each, a writer that survives being killed, a tolerant reader."""

from __future__ import annotations

from typing import TYPE_CHECKING

from firstcontact.core.lazy import lazily

if TYPE_CHECKING:
    from firstcontact.recording._reader import Recording, read_recording
    from firstcontact.recording._writer import RecordingWriter
    from firstcontact.recording.dataset import load_dataset, write_dataset
    from firstcontact.recording.exporting import export
    from firstcontact.recording.formats import EXPORTERS, IMPORTERS, Exporter, Importer
    from firstcontact.recording.header import Header, Marker, PinchMark
    from firstcontact.recording.importing import import_path
else:
    __getattr__ = lazily(
        __name__,
        {
            "dataset": "load_dataset write_dataset",
            "exporting": "export",
            "formats": "EXPORTERS IMPORTERS Exporter Importer",
            "header": "Header Marker PinchMark",
            "importing": "import_path",
            "_reader": "Recording read_recording",
            "_writer": "RecordingWriter",
        },
    )

__all__ = [
    "EXPORTERS",
    "IMPORTERS",
    "Exporter",
    "Header",
    "Importer",
    "Marker",
    "PinchMark",
    "Recording",
    "RecordingWriter",
    "export",
    "import_path",
    "load_dataset",
    "read_recording",
    "write_dataset",
]
