"""Sources of samples behind one interface, and the wire protocol of devices."""

from .descriptor import Descriptor as Descriptor
from .opening import SOURCES as SOURCES
from .opening import SourceKind as SourceKind
from .opening import open_source as open_source
from .source import Arrival as Arrival
from .source import Health as Health
from .source import Source as Source
