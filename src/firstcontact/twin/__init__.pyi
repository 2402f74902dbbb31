"""Pinch twin: a physical model of hand, fingertips and objects that makes recordings."""

from ._stream import TwinStream as TwinStream
from .draw import CONDITIONS as CONDITIONS
from .draw import draw_pinch as draw_pinch
from .household import find_object as find_object
from .objects import BLOCKS as BLOCKS
from .objects import TwinObject as TwinObject
from .pinch import simulate_pinch as simulate_pinch
from .simulation import simulate as simulate
