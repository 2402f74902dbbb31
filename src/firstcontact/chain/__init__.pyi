"""The chain in C: samples in, closings, contacts and estimates out."""

from ._events import ChainEvent as ChainEvent
from ._events import EventKind as EventKind
from ._events import Flag as Flag
from ._events import Reason as Reason
from ._extension import chain_extension as chain_extension
from ._image import DetectorConstants as DetectorConstants
from ._image import DetectorKind as DetectorKind
from ._image import Image as Image
from ._image import Layer as Layer
from ._image import Matrix as Matrix
from ._image import ModelConstants as ModelConstants
from ._image import ProcessConstants as ProcessConstants
from ._image import RigConstants as RigConstants
from ._image import build_image as build_image
from ._stream import Chain as Chain
from ._stream import Predict as Predict
from ._stream import ProgramDetector as ProgramDetector
from ._touch import predict_touches as predict_touches
from ._touch import shifts as shifts
from ._touch import spectra as spectra
from ._touch import touch_inputs as touch_inputs
