"""The chain in C: samples in, closings, contacts and estimates out."""

from ._events import ChainEvent as ChainEvent
from ._events import EventKind as EventKind
from ._events import Flag as Flag
from ._events import Reason as Reason
from .image import Image as Image
from .image import build_image as build_image
from .stream import Chain as Chain
