"""Answers at any time after a contact, for any rig, each with an interval."""

from firstcontact.anytime._model import Answering, Answers, AnytimeModel
from firstcontact.anytime.combining import Combined, combine
from firstcontact.anytime.in_context import InContextModel
from firstcontact.anytime.rig import Rig
from firstcontact.anytime.touch_stream import TouchStream
from firstcontact.anytime.touches import Touches, touches_of

__all__ = [
    "Answering",
    "Answers",
    "AnytimeModel",
    "Combined",
    "InContextModel",
    "Rig",
    "TouchStream",
    "Touches",
    "combine",
    "touches_of",
]
