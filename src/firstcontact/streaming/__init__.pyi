"""Streaming: samples in, contacts and estimates out, in real time; the page and other outputs."""

from ._pipeline import Pipeline as Pipeline
from ._sinks import Sink as Sink
from ._sinks import Update as Update
from .events import ClosingStart as ClosingStart
from .events import ContactEvent as ContactEvent
from .events import ContactWithdrawn as ContactWithdrawn
from .events import Event as Event
from .events import HandCheck as HandCheck
from .events import HandCommand as HandCommand
from .events import HandPinch as HandPinch
from .events import HandPrediction as HandPrediction
from .events import NoEstimate as NoEstimate
from .events import ObjectEstimate as ObjectEstimate
from .events import PinchDone as PinchDone
from .events import PolicyCommand as PolicyCommand
from .events import Verdict as Verdict
