"""Recordings: one MCAP file each, a writer that survives being killed, a tolerant reader."""

from ._arrays import from_arrays as from_arrays
from ._exporting import export as export
from ._formats import EXPORTERS as EXPORTERS
from ._formats import IMPORTERS as IMPORTERS
from ._formats import Exporter as Exporter
from ._formats import Importer as Importer
from ._reader import Recording as Recording
from ._reader import read_recording as read_recording
from ._writer import RecordingWriter as RecordingWriter
from .dataset import load_dataset as load_dataset
from .dataset import write_dataset as write_dataset
from .messages import Header as Header
from .messages import Marker as Marker
from .messages import PinchMark as PinchMark
